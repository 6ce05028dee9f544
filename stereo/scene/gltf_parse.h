/// JSON and buffers into a Document: the only place that knows tinygltf.
#pragma once

#include "stereo/scene/gltf_document.h"
#include "stereo/scene/gltf_files.h"

namespace farshade::gltf {

/// `file` passed open_container, check_json_depth and check_schema. Buffers and images that it names by URI
/// are read from `folder`; a missing buffer is an error, a missing image is said in Image::unreadable.
[[nodiscard]] Expected<Document> parse_document(std::span<const std::byte> file, bool is_binary,
                                                SceneFolder& folder);

}  // namespace farshade::gltf
