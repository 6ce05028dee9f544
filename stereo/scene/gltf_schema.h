/// Parses the JSON text of a glTF file, once, and checks its shape: every property that this program reads
/// has the type and the range that the specification gives it. Code that reads the JSON afterwards needs no
/// checks of types.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string_view>

#include "stereo/base/expected.h"

namespace farshade::gltf {

/// The root object. Refuses with the path of the property: "accessors[17].count should be a whole number from
/// 0 to 9007199254740991". The nesting depth of `json` must be bounded (check_json_depth). `has_bin`: the
/// file is a GLB with a binary chunk.
[[nodiscard]] Expected<nlohmann::json> parse_json(std::string_view json, bool has_bin);

}  // namespace farshade::gltf
