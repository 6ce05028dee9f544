/// Compressed buffer views and meshes become plain ones: EXT_meshopt_compression (meshoptimizer) and
/// KHR_draco_mesh_compression (gltf_draco.cpp). Everything after it reads accessors of plain bytes.
///
/// A small hostile file must not make large ones. Sizes come from the JSON and from the header of the
/// compressed bytes; they are compared with the compressed size and with one budget for the file before
/// anything is allocated.
#pragma once

#include "stereo/gltf/gltf_model.h"

namespace farshade::gltf {

/// The bytes that decoding may allocate for everything that a file compresses: 2^26 + 256 * bytes of its
/// buffers. Draco needs the most: about 180 bytes for a triangle, which it can compress to little more than
/// one byte.
class DecodedBudget {
 public:
  explicit DecodedBudget(const Document& document);

  /// OutOfRange, naming `name`, if fewer than `bytes` are left.
  [[nodiscard]] Checked take(const std::string& name, std::uint64_t bytes);

 private:
  std::uint64_t left_;
};

/// Decodes all compressed views and primitives into buffers of their own. A damaged view says so in its name,
/// a damaged primitive becomes an empty one. Refuses what exceeds the budget.
[[nodiscard]] Checked decompress(Document& document);

/// Decodes the primitives with Draco meshes: their attributes and indices become accessors of their own.
[[nodiscard]] Checked decompress_draco(Document& document, DecodedBudget& budget);

}  // namespace farshade::gltf
