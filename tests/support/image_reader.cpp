#include "tests/support/image_reader.h"

#include <png.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <optional>
#include <string_view>

#include "stereo/base/files.h"
#include "stereo/image/codec.h"
#include "stereo/image/formats.h"

namespace farshade {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMaxImagePixels = std::uint64_t{1} << 26;
constexpr std::uint64_t kMaxFileBytes = 16 * kMaxImagePixels + 65536;

/// Decodes the file with `decode`.
template <class Decode>
auto read_with(const fs::path& path, Decode decode) -> decltype(decode(std::span<const std::byte>{}, 0)) {
  const auto file = read_file(path, kMaxFileBytes);
  if (!file) return tl::unexpected(file.error());
  auto image = decode(*file, kMaxImagePixels);
  if (!image) return fail(image.error().fault, "'" + path.string() + "': " + image.error().what);
  return image;
}

/// libpng calls abort() on a damaged file: tests read only files that the programs wrote.
Expected<Image<std::uint16_t>> decode_png16(std::span<const std::byte> file, std::uint64_t max_pixels) {
  if (!is_png(file)) return fail(Fault::Unsupported, "not a PNG by its first bytes");
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_read_fn(png, &file, [](png_structp reader, png_bytep to, std::size_t count) {
    auto& rest = *static_cast<std::span<const std::byte>*>(png_get_io_ptr(reader));
    if (count > rest.size()) png_error(reader, "file is cut short");
    std::memcpy(to, rest.data(), count);
    rest = rest.subspan(count);
  });
  png_read_info(png, info);
  Image<std::uint16_t> image({png_get_image_width(png, info), png_get_image_height(png, info)});
  const bool is_grey16 =
      png_get_bit_depth(png, info) == 16 && png_get_color_type(png, info) == PNG_COLOR_TYPE_GRAY;
  const auto fits = check_size(image.size.width, image.size.height, max_pixels);
  if (is_grey16 && fits) {
    if (std::endian::native == std::endian::little) png_set_swap(png);
    for (std::uint32_t y = 0; y < image.size.height; ++y)
      png_read_row(png, reinterpret_cast<png_bytep>(&image.at(0, y)), nullptr);
    png_read_end(png, nullptr);
  }
  png_destroy_read_struct(&png, &info, nullptr);
  if (!is_grey16) return fail(Fault::Unsupported, "PNG is not 16-bit grey");
  return fits.map([&] { return std::move(image); });
}

/// Takes the next word of a header and the one white-space byte after it. Empty if there is none.
std::string_view take_word(std::string_view& text) {
  const std::size_t end = text.find_first_of(" \t\r\n");
  if (end == std::string_view::npos) return {};
  const std::string_view word = text.substr(0, end);
  text.remove_prefix(end + 1);
  return word;
}

template <class Number>
std::optional<Number> number_of(std::string_view word) {
  Number value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc{} && end == word.data() + word.size() ? std::optional(value) : std::nullopt;
}

Expected<Image<float>> decode_pfm(std::span<const std::byte> file, std::uint64_t max_pixels) {
  std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  if (take_word(text) != "Pf") return fail(Fault::Unsupported, "not a one-channel PFM");
  const auto width = number_of<std::uint32_t>(take_word(text));
  const auto height = number_of<std::uint32_t>(take_word(text));
  const auto scale = number_of<double>(take_word(text));
  if (!width || !height || !scale) return fail(Fault::Malformed, "faulty PFM header");
  if (!(*scale < 0)) return fail(Fault::Unsupported, "PFM is not little-endian");
  if (const auto fits = check_size(*width, *height, max_pixels); !fits) return tl::unexpected(fits.error());

  const std::size_t row_bytes = *width * sizeof(float);
  if (text.size() != *height * row_bytes) return fail(Fault::Malformed, "PFM's pixels do not fill its size");
  Image<float> image({*width, *height});
  const char* row = text.data();
  for (std::uint32_t y = *height; y-- > 0; row += row_bytes) std::memcpy(&image.at(0, y), row, row_bytes);
  return image;
}

}  // namespace

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

}  // namespace farshade
