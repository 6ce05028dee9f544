#include "stereo/image/codec.h"

#include <bit>
#include <cstring>
#include <string>

#include "stereo/base/files.h"
#include "stereo/image/formats.h"

namespace farshade {
namespace {

namespace fs = std::filesystem;

Expected<void> write_encoded(const fs::path& path, const Expected<std::vector<std::byte>>& bytes) {
  if (!bytes) return fail(bytes.error().fault, "cannot write '" + path.string() + "': " + bytes.error().what);
  return write_file_atomically(path, std::span<const std::byte>(*bytes));
}

static_assert(std::endian::native == std::endian::little, "floats are written as they lie in memory");

/// PFM: "Pf", width and height, -1.0 for little-endian, then floats, bottom row first
/// (P. Debevec, "Portable float map", netpbm's pfm(5)).
std::vector<std::byte> encode_pfm(const Image<float>& image) {
  const std::string header =
      "Pf\n" + std::to_string(image.size.width) + " " + std::to_string(image.size.height) + "\n-1.0\n";
  const std::size_t row_bytes = image.size.width * sizeof(float);
  std::vector<std::byte> bytes(header.size() + image.size.height * row_bytes);
  std::memcpy(bytes.data(), header.data(), header.size());
  std::byte* row = bytes.data() + header.size();
  for (std::uint32_t y = image.size.height; y-- > 0; row += row_bytes)
    std::memcpy(row, &image.at(0, y), row_bytes);
  return bytes;
}

}  // namespace

Expected<void> check_size(std::uint32_t width, std::uint32_t height, std::uint64_t max_pixels) {
  const std::string size = std::to_string(width) + "x" + std::to_string(height);
  if (width == 0 || height == 0) return fail(Fault::Malformed, "picture of " + size + " pixels has none");
  if (std::uint64_t{width} * height > max_pixels)
    return fail(Fault::OutOfRange,
                "picture of " + size + " pixels is over the limit of " + std::to_string(max_pixels));
  return {};
}

Expected<Image<Rgba8>> decode_image(std::span<const std::byte> file, std::uint64_t max_pixels) {
  if (is_png(file)) return decode_png(file, max_pixels);
  if (is_jpeg(file)) return decode_jpeg(file, max_pixels);
  if (is_webp(file)) return decode_webp(file, max_pixels);
  return fail(Fault::Unsupported, "picture is neither PNG nor JPEG nor WebP by its first bytes");
}

Expected<void> write_png(const fs::path& path, const Image<Rgb8>& image) {
  return write_encoded(path, encode_png(image));
}
Expected<void> write_png16(const fs::path& path, const Image<std::uint16_t>& image) {
  return write_encoded(path, encode_png16(image));
}
Expected<void> write_pfm(const fs::path& path, const Image<float>& image) {
  return write_file_atomically(path, std::span<const std::byte>(encode_pfm(image)));
}

}  // namespace farshade
