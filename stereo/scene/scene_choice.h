/// What a user chooses of a file that holds several scenes, cameras or variants of its materials. The choice
/// changes the scene, and so its hash: client and server need the same.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace farshade {

struct SceneChoice {
  std::optional<std::uint32_t> scene{};  ///< by its place in the file; none: the file's default
  std::string camera{};                  ///< the name of a camera or of its node; empty: the reference camera
  std::string variant{};  ///< of KHR_materials_variants; empty: the materials without a variant
};

}  // namespace farshade
