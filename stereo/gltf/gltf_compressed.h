/// Compressed buffer views and meshes become plain ones: EXT_meshopt_compression (meshoptimizer) and
/// KHR_draco_mesh_compression (gltf_draco.cpp). Everything after it reads accessors of plain bytes.
///
/// A small hostile file must not make large ones. Sizes come from the JSON and from the header of the
/// compressed bytes; they are compared with the compressed size and with one budget for the file before
/// anything is allocated.
#pragma once

#include "stereo/gltf/gltf_model.h"

namespace farshade::gltf {

/// Decodes all compressed views and primitives into buffers of their own. A damaged view says so in its name,
/// a damaged primitive becomes an empty one. Refuses what exceeds the budget: decoding may allocate
/// 2^26 + 256 * bytes of all buffers. Draco needs the most: about 180 bytes for a triangle, which it can
/// compress to little more than one byte.
[[nodiscard]] Checked decompress(Document& document);

inline constexpr const char* kTooMuch = " decodes to more bytes than a file of this size should have";

/// Decodes the primitives with Draco meshes: their attributes and indices become accessors of their own.
[[nodiscard]] Checked decompress_draco(Document& document, Budget& budget);

}  // namespace farshade::gltf
