/// PNG with libpng's row interface. The simplified interface would be shorter, but it applies gamma chunks.
#include <png.h>

#include <bit>
#include <cstdio>
#include <cstring>
#include <string>

#include "stereo/base/check.h"
#include "stereo/image/escape.h"
#include "stereo/image/formats.h"

namespace farshade {
namespace {

[[noreturn]] void on_error(png_structp png, png_const_charp message) {
  auto& escape = *static_cast<Escape*>(png_get_error_ptr(png));
  std::snprintf(escape.reason, sizeof escape.reason, "%s", message);
  std::longjmp(escape.landing, 1);
}
void on_warning(png_structp, png_const_charp) {}  // relevant warnings are errors, see png_set_benign_errors

void take_bytes(png_structp png, png_bytep to, std::size_t count) {
  auto& rest = *static_cast<std::span<const std::byte>*>(png_get_io_ptr(png));
  if (count > rest.size()) png_error(png, "file is cut short");
  std::memcpy(to, rest.data(), count);
  rest = rest.subspan(count);
}

/// A libpng reader of bytes in memory. libpng keeps its address, so it must not move.
struct Reader {
  Escape escape;
  std::span<const std::byte> rest;
  png_structp png = nullptr;
  png_infop info = nullptr;

  explicit Reader(std::span<const std::byte> file) : rest(file) {
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &escape, on_error, on_warning);
    if (png) info = png_create_info_struct(png);
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }

  [[nodiscard]] tl::unexpected<Error> refused() const {
    return fail(Fault::Malformed, std::string("faulty PNG: ") + escape.reason);
  }
};

/// Reads the header and checks that there are not too many pixels, nor more than the file can contain.
Expected<Extent> read_header(Reader& reader, std::size_t file_bytes, std::uint64_t max_pixels) {
  Extent size;
  if (!reader.info) return fail(Fault::Unavailable, "libpng cannot start");
  const bool read = runs_through(reader.escape, [&] {
    png_set_read_fn(reader.png, &reader.rest, take_bytes);
    png_set_benign_errors(reader.png, 0);
    // Keeps only chunks with pixels: no profiles, gamma or texts, which may decompress to any size.
    png_set_keep_unknown_chunks(reader.png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
    png_read_info(reader.png, reader.info);
    size = {png_get_image_width(reader.png, reader.info), png_get_image_height(reader.png, reader.info)};
  });
  if (!read) return reader.refused();
  if (const auto fits = check_size(size.width, size.height, max_pixels); !fits)
    return tl::unexpected(fits.error());
  // Deflate compresses at most 1032 : 1 (zlib's technical notes), so a small file cannot need much memory.
  if (std::uint64_t{size.height} * png_get_rowbytes(reader.png, reader.info) >
      1032 * std::uint64_t{file_bytes})
    return fail(Fault::Malformed, "faulty PNG: file is too short for its size in pixels");
  return size;
}

void grow(png_structp png, png_bytep from, std::size_t count) {
  auto& bytes = *static_cast<std::vector<std::byte>*>(png_get_io_ptr(png));
  const auto* first = reinterpret_cast<const std::byte*>(from);
  bytes.insert(bytes.end(), first, first + count);
}

template <class Pixel>
Expected<std::vector<std::byte>> encode(const Image<Pixel>& image, int bits, int color) {
  Escape escape;
  std::vector<std::byte> bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &escape, on_error, on_warning);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  if (!info) std::snprintf(escape.reason, sizeof escape.reason, "libpng cannot start");
  const bool written =
      info && runs_through(escape, [&] {
        png_set_write_fn(png, &bytes, grow, nullptr);
        png_set_IHDR(png, info, image.size.width, image.size.height, bits, color, PNG_INTERLACE_NONE,
                     PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
        png_write_info(png, info);
        if (bits == 16 && std::endian::native == std::endian::little) png_set_swap(png);
        for (std::uint32_t y = 0; y < image.size.height; ++y)
          png_write_row(png, reinterpret_cast<png_const_bytep>(&image.at(0, y)));
        png_write_end(png, info);
      });
  png_destroy_write_struct(&png, &info);
  if (!written) return fail(Fault::OutOfRange, std::string("PNG: ") + escape.reason);
  return bytes;
}

}  // namespace

bool is_png(std::span<const std::byte> file) {
  return file.size() >= 8 && png_sig_cmp(reinterpret_cast<png_const_bytep>(file.data()), 0, 8) == 0;
}

Expected<Image<Rgba8>> decode_png(std::span<const std::byte> file, std::uint64_t max_pixels) {
  Reader reader(file);
  const auto size = read_header(reader, file.size(), max_pixels);
  if (!size) return tl::unexpected(size.error());
  Image<Rgba8> image(*size);
  std::vector<png_bytep> rows(size->height);
  for (std::uint32_t y = 0; y < size->height; ++y) rows[y] = reinterpret_cast<png_bytep>(&image.at(0, y));
  const std::size_t row_bytes = size->width * sizeof(Rgba8);
  const bool read = runs_through(reader.escape, [&] {
    png_set_expand(reader.png);
    png_set_scale_16(reader.png);
    png_set_gray_to_rgb(reader.png);
    png_set_add_alpha(reader.png, 0xff, PNG_FILLER_AFTER);
    png_set_interlace_handling(reader.png);
    png_read_update_info(reader.png, reader.info);
    check_eq(png_get_rowbytes(reader.png, reader.info), row_bytes, "libpng's rows are as wide as ours");
    png_read_image(reader.png, rows.data());
    png_read_end(reader.png, nullptr);
  });
  if (!read) return reader.refused();
  return image;
}

Expected<std::vector<std::byte>> encode_png(const Image<Rgb8>& image) {
  return encode(image, 8, PNG_COLOR_TYPE_RGB);
}

Expected<std::vector<std::byte>> encode_png16(const Image<std::uint16_t>& image) {
  return encode(image, 16, PNG_COLOR_TYPE_GRAY);
}

}  // namespace farshade
