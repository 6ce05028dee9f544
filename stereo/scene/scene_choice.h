/// What a user chooses of a file that holds several scenes, cameras, animations or variants of its materials.
/// The choice changes the scene, and so its hash: client and server need the same.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace farshade {

struct SceneChoice {
  std::optional<std::uint32_t> scene{};  ///< by its place in the file; none: the file's default
  std::string camera{};                  ///< the name of a camera or of its node; empty: the reference camera
  std::string variant{};  ///< of KHR_materials_variants; empty: the materials without a variant
  /// The name of the animation that plays, `all` or `none`; empty: the first. An animation without a name is
  /// called by its place, such as "animation 3".
  std::string animation{};
};

}  // namespace farshade
