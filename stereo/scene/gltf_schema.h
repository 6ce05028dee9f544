/// The shape of a glTF file's JSON: every property that this program reads has the type and the sign that the
/// specification gives it. tinygltf takes a property of the wrong type for a missing one, and cuts integers
/// to 32 bits; after this check there is nothing left to misunderstand.
#pragma once

#include <string_view>

#include "stereo/base/expected.h"

namespace farshade::gltf {

/// Refuses with the property's path: "accessors[17].count should be a whole number from 0 to
/// 9007199254740991". `json` must not be nested deeply (check_json_depth). `has_bin`: the file is a GLB with
/// a binary chunk.
[[nodiscard]] Expected<void> check_schema(std::string_view json, bool has_bin);

}  // namespace farshade::gltf
