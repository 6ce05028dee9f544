#include "stereo/image/codec.h"

#include <algorithm>
#include <string>
#include <utility>

#include "stereo/base/files.h"
#include "stereo/image/formats.h"

namespace farshade {
namespace {

namespace fs = std::filesystem;

/// Largest file: more than 16 bytes a pixel, which is more than any format here needs.
constexpr std::uint64_t kMaxFileBytes = 16 * kMaxImagePixels + 65536;

/// Decodes the file with `decode`. Errors begin with the path.
template <class Decode>
auto read_with(const fs::path& path, Decode decode) -> decltype(decode(std::span<const std::byte>{}, 0)) {
  const auto file = read_file(path, kMaxFileBytes);
  if (!file) return tl::unexpected(file.error());
  auto image = decode(*file, kMaxImagePixels);
  if (!image) return fail(image.error().fault, "'" + path.string() + "': " + image.error().what);
  return image;
}

Expected<void> write_encoded(const fs::path& path, const Expected<std::vector<std::byte>>& bytes) {
  if (!bytes) return fail(bytes.error().fault, "cannot write '" + path.string() + "': " + bytes.error().what);
  return write_file_atomically(path, std::span<const std::byte>(*bytes));
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
  return fail(Fault::Unsupported, "picture is neither PNG nor JPEG by its first bytes");
}

Expected<Image<Rgb8>> read_png(const fs::path& path) {
  return read_with(path, decode_image).map([](const Image<Rgba8>& with_alpha) {
    Image<Rgb8> image(with_alpha.size);
    std::ranges::transform(with_alpha.pixels, image.pixels.begin(), [](Rgba8 p) { return Rgb8(p); });
    return image;
  });
}

Expected<Image<std::uint16_t>> read_png16(const fs::path& path) {
  return read_with(path, decode_png16);
}
Expected<Image<float>> read_pfm(const fs::path& path) {
  return read_with(path, decode_pfm);
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
