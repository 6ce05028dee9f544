#include "stereo/video/colours.h"

#include "stereo/base/check.h"

extern "C" {
#include <libswscale/swscale.h>
}

namespace farshade {

void ColourConverter::FreeScaler::operator()(SwsContext* scaler) const {
  sws_freeContext(scaler);
}

Expected<ColourConverter> ColourConverter::create(Extent size, To to) {
  // libswscale has fast code for planar RGB at full chroma resolution.
  const AVPixelFormat from_format = to == To::Yuv ? AV_PIX_FMT_GBRP : AV_PIX_FMT_YUV420P,
                      to_format = to == To::Yuv ? AV_PIX_FMT_YUV420P : AV_PIX_FMT_GBRP;
  const auto width = narrow<int>(size.width), height = narrow<int>(size.height);
  constexpr int flags =
      SWS_BILINEAR | SWS_ACCURATE_RND | SWS_BITEXACT | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP;
  Scaler scaler(
      sws_getContext(width, height, from_format, width, height, to_format, flags, nullptr, nullptr, nullptr));
  const int* bt709 = sws_getCoefficients(SWS_CS_ITU709);
  constexpr int full_range = 1, one = 1 << 16;
  if (!scaler ||
      sws_setColorspaceDetails(scaler.get(), bt709, full_range, bt709, full_range, 0, one, one) < 0)
    return fail(Fault::Unavailable, "libswscale does not convert pictures of " + std::to_string(size.width) +
                                        " x " + std::to_string(size.height));
  return ColourConverter(size, std::move(scaler));
}

ColourConverter::ColourConverter(Extent size, Scaler scaler)
    : size_(size),
      row_blocks_((size.width + sizeof(Block) - 1) / sizeof(Block)),
      planes_((3 * row_blocks_ * size.height) + 1),
      scaler_(std::move(scaler)) {}

std::uint8_t* ColourConverter::plane(std::size_t index) {
  return planes_[index * row_blocks_ * size_.height].bytes.data();
}

void ColourConverter::to_yuv(const Image<Rgb8>& rgb, const YuvPlanes<std::uint8_t>& yuv) {
  check(rgb.size == size_, "the picture has the converter's size");
  const std::size_t stride = row_blocks_ * sizeof(Block);
  const std::array<std::uint8_t*, 3> gbr{plane(0), plane(1), plane(2)};
  for (std::size_t y = 0; y < size_.height; ++y) {
    const Rgb8* row = &rgb.pixels[y * size_.width];
    for (std::size_t x = 0; x < size_.width; ++x) {
      gbr[0][y * stride + x] = row[x].g;
      gbr[1][y * stride + x] = row[x].b;
      gbr[2][y * stride + x] = row[x].r;
    }
  }
  const std::array<const std::uint8_t*, 3> from{gbr[0], gbr[1], gbr[2]};
  const auto step = narrow<int>(stride);
  const std::array<int, 3> steps{step, step, step};
  const int rows = sws_scale(scaler_.get(), from.data(), steps.data(), 0, narrow<int>(size_.height),
                             yuv.rows.data(), yuv.stride_bytes.data());
  check_eq(rows, narrow<int>(size_.height), "rows converted");
}

void ColourConverter::to_rgb(const YuvPlanes<const std::uint8_t>& yuv, Image<Rgb8>& rgb) {
  const std::size_t stride = row_blocks_ * sizeof(Block);
  const std::array<std::uint8_t*, 3> gbr{plane(0), plane(1), plane(2)};
  const auto step = narrow<int>(stride);
  const std::array<int, 3> steps{step, step, step};
  const int rows = sws_scale(scaler_.get(), yuv.rows.data(), yuv.stride_bytes.data(), 0,
                             narrow<int>(size_.height), gbr.data(), steps.data());
  check_eq(rows, narrow<int>(size_.height), "rows converted");
  if (rgb.size != size_) rgb = Image<Rgb8>(size_);
  for (std::size_t y = 0; y < size_.height; ++y) {
    Rgb8* row = &rgb.pixels[y * size_.width];
    for (std::size_t x = 0; x < size_.width; ++x)
      row[x] = Rgb8(gbr[2][y * stride + x], gbr[0][y * stride + x], gbr[1][y * stride + x]);
  }
}

}  // namespace farshade
