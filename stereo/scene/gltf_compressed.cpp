#include "stereo/scene/gltf_compressed.h"

#include <meshoptimizer.h>

namespace farshade::gltf {
namespace {

/// meshoptimizer's vertex codec needs at least one byte for each 64 bytes of a vertex block that it makes.
constexpr std::uint64_t kMostRatio = 64;
/// The first byte of vertices in the format of KHR_meshopt_compression, which meshoptimizer 0.18 cannot read.
constexpr std::uint8_t kNewerVertices = 0xa1;

using Bytes = std::vector<std::uint8_t>;

bool filter_fits(const MeshoptView& from) {
  if (from.filter == "NONE") return true;
  if (from.mode != "ATTRIBUTES") return false;
  if (from.filter == "OCTAHEDRAL") return from.stride == 4 || from.stride == 8;
  if (from.filter == "QUATERNION") return from.stride == 8;
  return from.filter == "EXPONENTIAL";
}

bool shape_fits(const MeshoptView& from) {
  if (from.mode == "ATTRIBUTES") return from.stride >= 4 && from.stride <= 256 && from.stride % 4 == 0;
  if (from.stride != 2 && from.stride != 4) return false;
  return from.mode == "INDICES" || (from.mode == "TRIANGLES" && from.count % 3 == 0);
}

Checked check_meshopt(const std::string& name, const MeshoptView& from, std::uint64_t view_bytes) {
  if (!filter_fits(from) || !shape_fits(from))
    return malformed(name + ": mode '" + printable(from.mode) + "', filter '" + printable(from.filter) +
                     "', stride " + std::to_string(from.stride) + " and count " + std::to_string(from.count) +
                     " do not fit each other");
  // Both numbers are below 2^53 and the stride is at most 256, so the product does not overflow.
  if (from.count > view_bytes || from.count * from.stride != view_bytes)
    return malformed(name + " decodes to " + std::to_string(from.count) + " elements of " +
                     std::to_string(from.stride) + " bytes, but its length is " + std::to_string(view_bytes));
  if (view_bytes > kMostRatio * from.source.bytes)
    return malformed(name + ": " + std::to_string(from.source.bytes) + " bytes are too few for " +
                     std::to_string(view_bytes));
  return {};
}

int decode(const MeshoptView& from, std::span<const std::uint8_t> source, Bytes& to) {
  if (from.mode == "ATTRIBUTES")
    return meshopt_decodeVertexBuffer(to.data(), from.count, from.stride, source.data(), source.size());
  if (from.mode == "TRIANGLES")
    return meshopt_decodeIndexBuffer(to.data(), from.count, from.stride, source.data(), source.size());
  return meshopt_decodeIndexSequence(to.data(), from.count, from.stride, source.data(), source.size());
}

void apply_filter(const MeshoptView& from, Bytes& bytes) {
  if (from.filter == "OCTAHEDRAL") meshopt_decodeFilterOct(bytes.data(), from.count, from.stride);
  if (from.filter == "QUATERNION") meshopt_decodeFilterQuat(bytes.data(), from.count, from.stride);
  if (from.filter == "EXPONENTIAL") meshopt_decodeFilterExp(bytes.data(), from.count, from.stride);
}

Checked decompress_view(Document& document, std::size_t index, DecodedBudget& budget) {
  const MeshoptView from = *document.views[index].meshopt;
  const std::string name = label("compressed buffer view", index);
  const auto source = bytes_of_view(document, name, from.source);
  if (!source) return tl::unexpected(source.error());
  auto checked = check_meshopt(name, from, document.views[index].bytes).and_then([&] {
    return budget.take(name, document.views[index].bytes);
  });
  if (!checked) return checked;
  Bytes bytes(document.views[index].bytes);
  if (decode(from, *source, bytes) != 0) {
    if (from.mode == "ATTRIBUTES" && source->front() == kNewerVertices)
      return fail(Fault::Unsupported, name +
                                          " is compressed in version 1 of its format: compress the file with "
                                          "EXT_meshopt_compression");
    return malformed(name + ": its compressed bytes are damaged");
  }
  apply_filter(from, bytes);
  document.views[index].buffer = static_cast<std::uint32_t>(document.buffers.size());
  document.views[index].offset = 0;
  document.buffers.push_back(std::move(bytes));
  return {};
}

}  // namespace

DecodedBudget::DecodedBudget(const Document& document) : left_(std::uint64_t{1} << 26) {
  for (const auto& buffer : document.buffers) left_ += 256 * buffer.size();
}

Checked DecodedBudget::take(const std::string& name, std::uint64_t bytes) {
  if (bytes > left_)
    return fail(Fault::OutOfRange, name + " decodes to more bytes than a file of this size should have");
  left_ -= bytes;
  return {};
}

Expected<std::span<const std::uint8_t>> bytes_of_view(const Document& document, const std::string& name,
                                                      const BufferView& view) {
  if (view.buffer >= document.buffers.size())
    return malformed(name + ": there is no " + label("buffer", view.buffer));
  const std::span<const std::uint8_t> buffer = document.buffers[view.buffer];
  if (view.offset > buffer.size() || view.bytes > buffer.size() - view.offset)
    return malformed(name + " reads beyond its buffer (" + std::to_string(buffer.size()) + " bytes)");
  return buffer.subspan(view.offset, view.bytes);
}

Checked decompress(Document& document) {
  DecodedBudget budget(document);
  for (std::size_t i = 0; i < document.views.size(); ++i)
    if (document.views[i].meshopt)
      if (auto checked = decompress_view(document, i, budget); !checked) return checked;
  return decompress_draco(document, budget);
}

}  // namespace farshade::gltf
