/// The table of the JSON members that the loader reads, with the type and the range of each by the
/// specification. tinygltf accepts wrong types and stores what nobody reads, so the table comes first.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "stereo/gltf/gltf_model.h"

namespace farshade::gltf {

/// Removes all members that are not in the table or have a wrong value, such as a text for "nodes[3].mesh".
/// An object that means nothing without them becomes one that is not drawn or, if something else names it,
/// one whose name tells the fault.
void keep_members(nlohmann::json& root, Repairs& repairs);

}  // namespace farshade::gltf
