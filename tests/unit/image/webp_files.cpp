#include "tests/unit/image/webp_files.h"

#include <webp/encode.h>

#include <random>

namespace farshade {

std::vector<std::byte> make_webp(const Image<Rgba8>& image, WebpKind kind) {
  const int width = static_cast<int>(image.size.width), height = static_cast<int>(image.size.height);
  const auto* pixels = reinterpret_cast<const std::uint8_t*>(image.pixels.data());
  std::uint8_t* made = nullptr;
  const std::size_t size = kind == WebpKind::Lossless
                               ? WebPEncodeLosslessRGBA(pixels, width, height, 4 * width, &made)
                               : WebPEncodeRGBA(pixels, width, height, 4 * width, 80, &made);
  const auto* first = reinterpret_cast<const std::byte*>(made);
  std::vector<std::byte> file(first, first + size);
  WebPFree(made);
  return file;
}

std::vector<std::byte> make_noise_webp(Extent size) {
  std::mt19937 random(7);
  Image<Rgba8> image(size);
  for (Rgba8& p : image.pixels)
    p = Rgba8(random() & 255, random() & 255, random() & 255, 128 + (random() & 127));
  return make_webp(image);
}

}  // namespace farshade
