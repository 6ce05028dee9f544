/// What a file may ask for: which extensions the loader knows, and what of a file it does not draw.
/// docs/limits.md has a table of both.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "stereo/base/expected.h"

namespace farshade::gltf {

/// The names of all extensions that the loader knows something about.
[[nodiscard]] std::vector<std::string_view> known_extensions();

/// Unsupported, naming the first required extension without which the scene would be wrong. `root` may have
/// any members.
[[nodiscard]] Expected<void> check_extensions(const nlohmann::json& root);

/// What the file has and is not drawn as it says: one sentence a kind. `root` may have any members.
[[nodiscard]] std::vector<std::string> look_warnings(const nlohmann::json& root);

}  // namespace farshade::gltf
