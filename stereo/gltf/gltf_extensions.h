/// The JSON of a file before it is read: which extensions and members the loader knows, and what of a file it
/// does not draw. docs/limits.md has a table of both.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "stereo/gltf/gltf_repairs.h"

namespace farshade::gltf {

/// The names of all extensions that the loader knows something about.
[[nodiscard]] std::vector<std::string_view> known_extensions();

/// Unsupported, naming the first required extension without which the scene would be wrong. `root` may have
/// any members.
[[nodiscard]] Expected<void> check_extensions(const nlohmann::json& root);

/// What the file has and is not drawn as it says: one sentence a kind. `root` may have any members.
[[nodiscard]] std::vector<std::string> look_warnings(const nlohmann::json& root);

/// Removes all members that are not in the table of those that the loader reads (gltf_members.cpp), or have a
/// wrong value, such as a text for "nodes[3].mesh". An object that means nothing without them becomes one
/// that is not drawn or, if something else names it, one whose name tells the fault.
void keep_members(nlohmann::json& root, Repairs& repairs);

}  // namespace farshade::gltf
