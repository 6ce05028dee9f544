/// Builds a Document from the JSON text and from the buffers and images that it names.
#pragma once

#include "stereo/scene/gltf_document.h"
#include "stereo/scene/gltf_files.h"

namespace farshade::gltf {

/// Parses the text once. `bin` is the binary chunk of a GLB; it is empty for a .gltf file. Buffers and images
/// that are named by a relative URI are read from `folder`. Refuses text that is not JSON, members of a wrong
/// type or range (gltf_json.h), buffers that are missing or have another size than the JSON says, and images
/// whose data URI cannot be decoded. For an image file that cannot be read, Image::unreadable says why. The
/// nesting depth of the text must be bounded (check_json_depth).
[[nodiscard]] Expected<Document> parse_document(std::string_view text, std::span<const std::byte> bin,
                                                SceneFolder& folder);

}  // namespace farshade::gltf
