#include "tests/unit/image/image_files.h"

#include <cstdio>
#include <cstdlib>
#include <random>
// libjpeg's header needs FILE declared before it.
#include <jpeglib.h>
#include <png.h>
#include <zlib.h>

#include "stereo/base/check.h"

namespace farshade {
namespace {

void append(png_structp png, png_bytep from, std::size_t count) {
  auto& file = *static_cast<std::vector<std::byte>*>(png_get_io_ptr(png));
  const auto* first = reinterpret_cast<const std::byte*>(from);
  file.insert(file.end(), first, first + count);
}

enum class Text { None, Faulty };

std::vector<std::byte> encode_png(Extent size, int bits, int color, int interlace,
                                  std::vector<std::uint8_t> rows, Text text = Text::None) {
  std::vector<std::byte> file;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  check(setjmp(png_jmpbuf(png)) == 0, "libpng writes what the test asks for");
  png_set_write_fn(png, &file, append, nullptr);
  png_set_IHDR(png, info, size.width, size.height, bits, color, interlace, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  if (color == PNG_COLOR_TYPE_PALETTE) {
    const png_color palette[] = {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {255, 255, 255}};
    const png_byte alpha[] = {255, 128};
    png_set_PLTE(png, info, palette, 4);
    png_set_tRNS(png, info, alpha, 2, nullptr);
  }
  png_write_info_before_PLTE(png, info);
  constexpr png_byte zero[4] = {};
  if (text == Text::Faulty) png_write_chunk(png, reinterpret_cast<png_const_bytep>("zTXt"), zero, 4);
  png_write_info(png, info);
  const std::size_t row_bytes = png_get_rowbytes(png, info);
  rows.resize(row_bytes * size.height);
  std::vector<png_bytep> row_starts;
  for (std::uint32_t y = 0; y < size.height; ++y) row_starts.push_back(rows.data() + y * row_bytes);
  png_write_image(png, row_starts.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return file;
}

/// The legal script with the most scans without refinement: a scan for each coefficient of each component.
std::vector<jpeg_scan_info> one_scan_a_coefficient() {
  std::vector<jpeg_scan_info> scans{{3, {0, 1, 2, 0}, 0, 0, 0, 0}};
  for (int component = 0; component < 3; ++component)
    for (int k = 1; k < 64; ++k) scans.push_back({1, {component, 0, 0, 0}, k, k, 0, 0});
  return scans;
}

}  // namespace

std::vector<std::byte> make_png(Extent size, int bits, int color, const std::vector<std::uint8_t>& rows) {
  return encode_png(size, bits, color, PNG_INTERLACE_NONE, rows);
}

std::vector<std::byte> make_noise_png(Extent size) {
  std::mt19937 random(1);
  std::vector<std::uint8_t> rows(size.pixels() * 4);
  for (std::uint8_t& value : rows) value = static_cast<std::uint8_t>(random());
  return encode_png(size, 8, PNG_COLOR_TYPE_RGB_ALPHA, PNG_INTERLACE_ADAM7, rows);
}

std::vector<std::byte> make_png_with_faulty_text() {
  return encode_png({1, 1}, 8, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, {77}, Text::Faulty);
}

std::vector<std::byte> make_png_with_extra_row() {
  auto file = encode_png({1, 2}, 8, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, {77, 77});
  // The header chunk: its name at 12, width at 16, height at 20, end at 29, and then its checksum.
  file[23] = std::byte{1};
  const auto sum = crc32(0, reinterpret_cast<const Bytef*>(file.data() + 12), 17);
  for (std::size_t i = 0; i < 4; ++i) file[29 + i] = static_cast<std::byte>(sum >> (24 - 8 * i));
  return file;
}

std::vector<std::byte> make_jpeg(Extent size, JpegKind kind) {
  jpeg_error_mgr errors;
  jpeg_compress_struct jpeg;
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* bytes = nullptr;
  unsigned long count = 0;
  jpeg_mem_dest(&jpeg, &bytes, &count);
  jpeg.image_width = size.width;
  jpeg.image_height = size.height;
  jpeg.input_components = kind == JpegKind::Grey ? 1 : kind == JpegKind::Cmyk ? 4 : 3;
  jpeg.in_color_space = kind == JpegKind::Grey ? JCS_GRAYSCALE : kind == JpegKind::Cmyk ? JCS_CMYK : JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, 95, TRUE);
  if (kind == JpegKind::Progressive) jpeg_simple_progression(&jpeg);
  const auto scans = one_scan_a_coefficient();
  if (kind == JpegKind::ManyScans) {
    jpeg.scan_info = scans.data();
    jpeg.num_scans = static_cast<int>(scans.size());
  }
  jpeg_start_compress(&jpeg, TRUE);
  std::vector<std::uint8_t> row;
  for (std::uint32_t x = 0; x < size.width; ++x)
    for (const int value : {200, 100, 50, 0}) {
      if (row.size() < (x + 1) * static_cast<std::size_t>(jpeg.input_components))
        row.push_back(static_cast<std::uint8_t>(value));
    }
  for (std::uint32_t y = 0; y < size.height; ++y) {
    JSAMPROW start = row.data();
    jpeg_write_scanlines(&jpeg, &start, 1);
  }
  jpeg_finish_compress(&jpeg);
  jpeg_destroy_compress(&jpeg);
  const auto* first = reinterpret_cast<const std::byte*>(bytes);
  std::vector<std::byte> file(first, first + count);
  std::free(bytes);
  return file;
}

}  // namespace farshade
