/// Deformable: the vertices of a mesh before a rig moves them, and what each of them follows. First the
/// weighted differences of morph targets are added, then a skin blends the transforms of up to four joints
/// (glTF 2.0, 3.7.2.2 and 3.7.3.3). deform.h computes the result.
#pragma once

#include <cstdint>
#include <glm/gtc/type_precision.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

namespace farshade {

struct Deformable {
  struct Target {
    std::vector<glm::vec3> positions{}, normals{};  ///< differences; either may be empty
  };
  struct Influence {
    glm::u16vec4 joints{0};   ///< into Rig::joints
    glm::vec4 weights{0.0f};  ///< at least 0; their sum is 1
  };
  std::vector<glm::vec3> positions{};
  std::vector<glm::vec3> normals{};  ///< unit; empty: flat, vertices 3 i to 3 i + 2 form triangle i
  std::vector<Target> targets{};
  std::vector<Influence> influences{};  ///< one per vertex; empty: no skin
};

}  // namespace farshade
