#include "tests/study/comparison.h"

#include <gtest/gtest.h>

#include "stereo/metrics/flip.h"
#include "tests/support/image_reader.h"
#include "tests/unit/scratch_folder.h"

namespace farshade::study {
namespace {

constexpr Extent kSize{32, 32};

Image<Rgb8> grey(std::uint8_t level) {
  return Image<Rgb8>(kSize, Rgb8{level, level, level});
}

/// Grey with a square of another level, which lowers SSIM.
Image<Rgb8> with_square(std::uint8_t level = 255) {
  Image<Rgb8> image = grey(128);
  for (std::uint32_t y = 8; y < 24; ++y)
    for (std::uint32_t x = 8; x < 24; ++x) image.at(x, y) = {level, level, level};
  return image;
}

MeasuredFrame frame(const PerEye<Image<Rgb8>>& shown) {
  const Image<Rgb8> reference = grey(128);
  return {.frame = {1},
          .shown = shown,
          .reference = {reference, reference},
          .flip = {flip(reference, shown[0], 20), flip(reference, shown[1], 20)},
          .report = {},
          .ages = {}};
}

PerEye<View> views() {
  View view;
  view.fov = {-0.7, 0.7, 0.7, -0.7};
  view.size = kSize;
  return {view, view};
}

nlohmann::json errors_of(const PerEye<Image<Rgb8>>& shown) {
  Figures figures;
  Comparison(figures).add_smooth(views(), shown, {grey(128), grey(128)});
  return figures.json()["error"];
}

TEST(Comparison, TellsTheWorseEyeAgainstSmoothEdges) {
  const nlohmann::json left = errors_of({with_square(), grey(128)}),
                       right = errors_of({grey(128), with_square()}),
                       none = errors_of({grey(128), grey(128)});
  EXPECT_LT(left["smooth_psnr"]["median"], 15);
  EXPECT_GT(left["smooth_flip"]["median"], 0.05);
  EXPECT_LT(left["smooth_ssim"]["median"], 0.95);
  EXPECT_EQ(left, right);
  EXPECT_EQ(none["smooth_psnr"]["median"], kEqualPictures_dB);
  EXPECT_EQ(none["smooth_flip"]["median"], 0.0);
  EXPECT_EQ(none["smooth_ssim"]["median"], 1.0);
}

TEST(Comparison, WritesTheFrameWithTheLargestFlip) {
  const ScratchFolder folder;
  Figures figures;
  Comparison comparison(figures);
  ASSERT_TRUE(comparison.write(folder.path()));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << "no frame was compared";
  for (const std::uint8_t level : std::initializer_list<std::uint8_t>{140, 255, 150})
    comparison.add(frame({grey(128), with_square(level)}));
  ASSERT_TRUE(comparison.write(folder.path()));
  EXPECT_EQ(read_png(folder.path() / "left_shown.png").value(), grey(128));
  EXPECT_EQ(read_png(folder.path() / "right_shown.png").value(), with_square(255));
  EXPECT_EQ(read_png(folder.path() / "right_reference.png").value(), grey(128));
  EXPECT_NE(read_png(folder.path() / "right_heat.png").value(),
            read_png(folder.path() / "left_heat.png").value());
}

}  // namespace
}  // namespace farshade::study
