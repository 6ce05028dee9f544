/// Reads a Document from the JSON text of a file, and the buffers and images that it names.
#pragma once

#include "stereo/gltf/gltf_files.h"
#include "stereo/gltf/gltf_model.h"

namespace farshade::gltf {

/// Buffers and images that are named by a relative URI are read from `folder`. Refuses text that is not JSON,
/// and versions and extensions that cannot be read. A buffer that cannot be read as a whole says why in its
/// name; of an image, Document::unreadable says it. The nesting depth of the text must be bounded
/// (check_json_depth).
[[nodiscard]] Expected<Document> read_document(const Container& container, SceneFolder& folder);

}  // namespace farshade::gltf
