/// The table of the JSON members that the loader reads, with the type and the range of each by the
/// specification. tinygltf accepts wrong types and stores what nobody reads, so the table comes first.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "stereo/gltf/gltf_model.h"

namespace farshade::gltf {

/// Checks the members of `root` that say what a program must be able to read: version and extensions. Other
/// faults of a file often follow from them.
[[nodiscard]] Checked check_needs(const nlohmann::json& root);

/// Checks all members of the table and removes all others. Returns the first fault, such as
/// "accessors[17].count should be a whole number from 1 to 9007199254740991".
[[nodiscard]] Checked keep_members(nlohmann::json& root);

}  // namespace farshade::gltf
