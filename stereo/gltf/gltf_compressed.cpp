#include <meshoptimizer.h>

#include "stereo/gltf/gltf_accessor.h"
#include "stereo/gltf/gltf_stages.h"

namespace farshade::gltf {
namespace {

/// meshoptimizer's vertex codec needs at least one byte for each 64 bytes of a vertex block that it makes.
constexpr std::uint64_t kMostRatio = 64;
/// The first byte of vertices in the format of KHR_meshopt_compression, which meshoptimizer 0.18 cannot read.
constexpr std::uint8_t kNewerVertices = 0xa1;

/// EXT_meshopt_compression of a view, or its newer name. Mode and filter are as the extension spells them.
struct MeshoptView {
  int buffer = 0;
  std::size_t offset = 0, bytes = 0;  ///< of the compressed bytes
  std::size_t stride = 0, count = 0;
  std::string mode, filter;
};

std::optional<MeshoptView> meshopt_of(const BufferView& view) {
  const auto* from = extension(view.extensions, "KHR_meshopt_compression");
  if (!from) from = extension(view.extensions, "EXT_meshopt_compression");
  if (!from) return std::nullopt;
  const auto size = [&](const char* name) -> std::size_t { return index_member(from, name).value_or(0); };
  return MeshoptView{.buffer = from->Get("buffer").GetNumberAsInt(),
                     .offset = size("byteOffset"),
                     .bytes = size("byteLength"),
                     .stride = size("byteStride"),
                     .count = size("count"),
                     .mode = text_member(from, "mode"),
                     .filter = text_member(from, "filter", "NONE")};
}

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
  // The count is below 2^31 and the stride is at most 256, so the product does not overflow.
  if (from.count > view_bytes || from.count * from.stride != view_bytes)
    return malformed(name + " decodes to " + std::to_string(from.count) + " elements of " +
                     std::to_string(from.stride) + " bytes, but its length is " + std::to_string(view_bytes));
  if (view_bytes > kMostRatio * from.bytes)
    return malformed(name + ": " + std::to_string(from.bytes) + " bytes are too few for " +
                     std::to_string(view_bytes));
  return {};
}

int decode(const MeshoptView& from, ByteSpan source, Bytes& to) {
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

Checked decompress_view(Document& document, std::size_t index, const MeshoptView& from, Budget& budget) {
  BufferView& view = document.bufferViews[index];
  const std::string name = label("compressed buffer view", index);
  const auto source = bytes_in_buffer(document, name, from.buffer, from.offset, from.bytes);
  if (!source) return tl::unexpected(source.error());
  Checked checked = check_meshopt(name, from, view.byteLength).and_then([&] {
    return budget.take(view.byteLength, name + kTooMuch);
  });
  if (!checked) return checked;
  Bytes bytes(view.byteLength);
  if (decode(from, *source, bytes) != 0) {
    if (from.mode == "ATTRIBUTES" && source->front() == kNewerVertices)
      return fail(Fault::Unsupported, name +
                                          " is compressed in version 1 of its format: compress the file with "
                                          "EXT_meshopt_compression");
    return malformed(name + ": its compressed bytes are damaged");
  }
  apply_filter(from, bytes);
  view.buffer = static_cast<int>(document.buffers.size());
  view.byteOffset = 0;
  document.buffers.emplace_back().data = std::move(bytes);
  return {};
}

}  // namespace

Checked decompress(Document& document) {
  Budget budget((std::uint64_t{1} << 26) + 256 * buffer_bytes(document));
  for (std::size_t i = 0; i < document.bufferViews.size(); ++i) {
    const auto from = meshopt_of(document.bufferViews[i]);
    const Checked decoded = from ? decompress_view(document, i, *from, budget) : Checked{};
    if (!decoded && decoded.error().fault == Fault::OutOfRange) return decoded;
    if (!decoded) document.bufferViews[i].name = decoded.error().what;
  }
  return decompress_draco(document, budget);
}

}  // namespace farshade::gltf
