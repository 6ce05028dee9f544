/// Builds a Document from the checked JSON and from the buffers and images that the JSON names.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "stereo/scene/gltf_document.h"
#include "stereo/scene/gltf_files.h"

namespace farshade::gltf {

/// `root` comes from parse_json. `bin` is the binary chunk of a GLB; it is empty for a .gltf file. Buffers
/// and images that are named by a relative URI are read from `folder`. Refuses buffers that are missing or
/// have another size than the JSON says, and images whose data URI cannot be decoded. For an image file that
/// cannot be read, Image::unreadable says why.
[[nodiscard]] Expected<Document> parse_document(const nlohmann::json& root, std::span<const std::byte> bin,
                                                SceneFolder& folder);

}  // namespace farshade::gltf
