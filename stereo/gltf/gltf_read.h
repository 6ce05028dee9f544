/// Reads a Document from the JSON text of a file, and the buffers and images that it names.
#pragma once

#include "stereo/gltf/gltf_files.h"
#include "stereo/gltf/gltf_model.h"

namespace farshade::gltf {

/// `bin` is the binary chunk of a GLB; it is empty for a .gltf file. Buffers and images that are named by a
/// relative URI are read from `folder`. Refuses text that is not JSON, members of a wrong type or range
/// (gltf_members.h), buffers that are missing or have another size than the JSON says, and images whose data
/// URI cannot be decoded. For an external image that cannot be read, Document::unreadable says why. The
/// nesting depth of the text must be bounded (check_json_depth).
[[nodiscard]] Expected<Document> read_document(std::string_view text, std::span<const std::byte> bin,
                                               SceneFolder& folder);

}  // namespace farshade::gltf
