/// WebP with libwebp. The header is checked before any pixel is decoded, and the pixels are decoded into our
/// memory.
#include <webp/decode.h>

#include <cstring>
#include <string>

#include "stereo/image/formats.h"

namespace farshade {
namespace {

const std::uint8_t* bytes_of(std::span<const std::byte> file) {
  return reinterpret_cast<const std::uint8_t*>(file.data());
}

}  // namespace

bool is_webp(std::span<const std::byte> file) {
  return file.size() >= 12 && std::memcmp(file.data(), "RIFF", 4) == 0 &&
         std::memcmp(file.data() + 8, "WEBP", 4) == 0;
}

Expected<Image<Rgba8>> decode_webp(std::span<const std::byte> file, std::uint64_t max_pixels) {
  WebPBitstreamFeatures features{};
  if (WebPGetFeatures(bytes_of(file), file.size(), &features) != VP8_STATUS_OK)
    return fail(Fault::Malformed, "faulty WebP: its header is damaged");
  if (features.has_animation) return fail(Fault::Unsupported, "WebP is an animation, which is not supported");
  const Extent size{static_cast<std::uint32_t>(features.width), static_cast<std::uint32_t>(features.height)};
  if (const auto fits = check_size(size.width, size.height, max_pixels); !fits)
    return tl::unexpected(fits.error());
  Image<Rgba8> image(size);
  const std::size_t row_bytes = size.width * sizeof(Rgba8);
  if (!WebPDecodeRGBAInto(bytes_of(file), file.size(), reinterpret_cast<std::uint8_t*>(image.pixels.data()),
                          row_bytes * size.height, static_cast<int>(row_bytes)))
    return fail(Fault::Malformed, "faulty WebP: its pixels are damaged or cut short");
  return image;
}

}  // namespace farshade
