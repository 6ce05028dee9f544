/// JPEG with libjpeg-turbo. Every warning of libjpeg (truncated or damaged data, which it fills with grey) is
/// an error here.
#include <cstddef>
#include <cstdio>
// libjpeg's header needs the declarations of FILE and size_t.
#include <jpeglib.h>

#include <string>

#include "stereo/image/escape.h"
#include "stereo/image/formats.h"

namespace farshade {
namespace {

/// Most scans of a progressive picture; normal ones have about ten. Each scan costs a pass over all pixels.
constexpr int kMaxScans = 64;

struct ErrorManager : jpeg_error_mgr {
  Escape escape;
};

[[noreturn]] void on_error(j_common_ptr jpeg) {
  auto& escape = static_cast<ErrorManager*>(jpeg->err)->escape;
  jpeg->err->format_message(jpeg, escape.reason);
  std::longjmp(escape.landing, 1);
}
void on_message(j_common_ptr jpeg, int level) {
  if (level < 0) on_error(jpeg);
}
void on_progress(j_common_ptr jpeg) {
  auto& escape = static_cast<ErrorManager*>(jpeg->err)->escape;
  if (reinterpret_cast<j_decompress_ptr>(jpeg)->input_scan_number <= kMaxScans) return;
  std::snprintf(escape.reason, sizeof escape.reason, "more than %d scans", kMaxScans);
  std::longjmp(escape.landing, 1);
}

/// A libjpeg reader of bytes in memory. libjpeg keeps its address, so it must not move.
struct Reader {
  ErrorManager errors{};
  jpeg_progress_mgr progress{};
  jpeg_decompress_struct jpeg{};

  Reader() {
    jpeg.err = jpeg_std_error(&errors);
    errors.error_exit = on_error;
    errors.emit_message = on_message;
    progress.progress_monitor = on_progress;
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() { jpeg_destroy_decompress(&jpeg); }

  [[nodiscard]] tl::unexpected<Error> refused() const {
    return fail(Fault::Malformed, std::string("faulty JPEG: ") + errors.escape.reason);
  }
};

}  // namespace

bool is_jpeg(std::span<const std::byte> file) {
  return file.size() >= 3 && file[0] == std::byte{0xff} && file[1] == std::byte{0xd8} &&
         file[2] == std::byte{0xff};
}

Expected<Image<Rgba8>> decode_jpeg(std::span<const std::byte> file, std::uint64_t max_pixels) {
  Reader reader;
  jpeg_decompress_struct& jpeg = reader.jpeg;
  const bool header_read = runs_through(reader.errors.escape, [&] {
    jpeg_create_decompress(&jpeg);
    jpeg.progress = &reader.progress;
    jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(file.data()), file.size());
    jpeg_read_header(&jpeg, TRUE);
  });
  if (!header_read) return reader.refused();
  if (const auto fits = check_size(jpeg.image_width, jpeg.image_height, max_pixels); !fits)
    return tl::unexpected(fits.error());
  if (jpeg.jpeg_color_space != JCS_YCbCr && jpeg.jpeg_color_space != JCS_GRAYSCALE &&
      jpeg.jpeg_color_space != JCS_RGB)
    return fail(Fault::Unsupported, "JPEG is neither colour (YCbCr, RGB) nor grey; CMYK is not supported");

  Image<Rgba8> image({jpeg.image_width, jpeg.image_height});
  const bool pixels_read = runs_through(reader.errors.escape, [&] {
    jpeg.out_color_space = JCS_EXT_RGBA;  // of libjpeg-turbo; alpha is 255
    jpeg_start_decompress(&jpeg);
    while (jpeg.output_scanline < jpeg.output_height) {
      auto* row = reinterpret_cast<JSAMPROW>(&image.at(0, jpeg.output_scanline));
      jpeg_read_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_decompress(&jpeg);
  });
  if (!pixels_read) return reader.refused();
  return image;
}

}  // namespace farshade
