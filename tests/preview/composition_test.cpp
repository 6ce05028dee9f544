#include "vr_client/preview/composition.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace farshade {
namespace {

constexpr Extent kEye{512, 512};

TEST(PanelRects, AreUnscaledIfThatNearlyFillsTheWindow) {
  EXPECT_EQ(panel_rects({1040, 540}, kEye, 1, StereoLayout::SideBySide),
            (std::vector<Panel>{{4, 14, kEye, 0}, {524, 14, kEye, 1}}));
  EXPECT_EQ(panel_rects({1024, 512}, kEye, 1.0000001, StereoLayout::SideBySide),
            (std::vector<Panel>{{0, 0, kEye, 0}, {512, 0, kEye, 1}}));
  EXPECT_EQ(panel_rects({639, 639}, kEye, 1, StereoLayout::Mono)[0].size, kEye);
}

TEST(PanelRects, FillALargerOrSmallerWindow) {
  EXPECT_EQ(panel_rects({640, 900}, kEye, 1, StereoLayout::Mono)[0], (Panel{0, 130, {640, 640}, 0}));
  EXPECT_EQ(panel_rects({1000, 900}, kEye, 1, StereoLayout::SideBySide)[1], (Panel{500, 200, {500, 500}, 1}));
}

TEST(PanelRects, CrossedEyesAreSwapped) {
  const auto panels = panel_rects({1040, 540}, kEye, 1, StereoLayout::CrossEyed);
  EXPECT_EQ(panels[0], (Panel{4, 14, kEye, 1}));
  EXPECT_EQ(panels[1], (Panel{524, 14, kEye, 0}));
}

TEST(PanelRects, MonoAndAnaglyphHaveOneCentredPanel) {
  for (const StereoLayout layout : {StereoLayout::Mono, StereoLayout::Anaglyph})
    EXPECT_EQ(panel_rects({1040, 540}, kEye, 1, layout), (std::vector<Panel>{{264, 14, kEye, 0}}));
}

TEST(PanelRects, KeepTheShapeOfNonSquarePixels) {
  const auto panels = panel_rects({512, 512}, kEye, 2, StereoLayout::Mono);
  EXPECT_EQ(panels[0], (Panel{0, 128, {512, 256}, 0}));
}

TEST(PanelRects, KeepTheAspectRatioAndStayInTheirHalf) {
  constexpr unsigned seed = 5;
  std::mt19937 random(seed);
  std::uniform_int_distribution<std::uint32_t> side(1, 3000);
  std::uniform_real_distribution<double> log_aspect(-2, 2);
  for (int i = 0; i < 20'000; ++i) {
    const Extent window{side(random), side(random)}, eye{side(random), side(random)};
    const double aspect = std::exp(log_aspect(random));
    for (const Panel& panel : panel_rects(window, eye, aspect, StereoLayout::SideBySide)) {
      ASSERT_LE(panel.left + panel.size.width, window.width / 2 * (panel.eye + 1))
          << "seed " << seed << ", " << i;
      ASSERT_GE(panel.left, window.width / 2 * panel.eye);
      ASSERT_LE(panel.top + panel.size.height, window.height);
      ASSERT_NEAR(panel.size.width, panel.size.height * aspect, 0.5 + 0.5 * aspect);
    }
  }
}

TEST(PanelRects, AreEmptyIfNoPixelFits) {
  EXPECT_TRUE(panel_rects({0, 0}, kEye, 1, StereoLayout::Mono).empty());
  EXPECT_TRUE(panel_rects({1, 100}, kEye, 1, StereoLayout::SideBySide).empty());
  EXPECT_TRUE(panel_rects({1, 100}, kEye, 1000, StereoLayout::Mono).empty());
}

TEST(SharedColumns, AreAllColumnsOfEqualEyes) {
  const EyeFov fov{-0.7, 0.7, 0.6, -0.6};
  EXPECT_EQ(shared_columns({fov, fov}, 0, kEye), (SharedColumns{{0, 0}, kEye.width}));
}

TEST(SharedColumns, PutPointsAtTheScreenIntoOneColumn) {
  const PerEye<EyeFov> fov{EyeFov{-0.9, 0.7, 0.6, -0.6}, EyeFov{-0.7, 0.9, 0.6, -0.6}};
  const double apart_m = 0.2;
  const SharedColumns shared = shared_columns(fov, apart_m, kEye);
  EXPECT_GT(shared.count, 0u);
  EXPECT_LT(shared.count, kEye.width);
  PerEye<double> column{};
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    EXPECT_LE(shared.first[eye] + shared.count, kEye.width);
    const double x = (eye == 0 ? apart_m : -apart_m) / 2;
    column[eye] = ray_pixel(tangents_of(fov[eye]), kEye, {x, 0, -kScreen_m}).x - shared.first[eye];
  }
  EXPECT_NEAR(column[0], column[1], 1);
}

TEST(SharedColumns, AreAllColumnsIfNoneIsShared) {
  EXPECT_EQ(shared_columns({EyeFov{-1, -0.5, 0.6, -0.6}, EyeFov{0.5, 1, 0.6, -0.6}}, 0, kEye),
            SharedColumns{});
}

TEST(LeftOf, LeavesRoomForThePanel) {
  EXPECT_EQ(left_of({1000, 700}, 330), (Extent{670, 700}));
  EXPECT_EQ(left_of({200, 700}, 330), (Extent{0, 700}));
}

TEST(PixelAt, FindsTheEyeAndThePixelUnderAPlace) {
  const Composition composition{.right_px = 100};
  const Extent window{1140, 540};
  EXPECT_EQ(pixel_at(composition, window, kEye, {4, 14}), (PixelOfEye{0, {0, 0}}));
  EXPECT_EQ(pixel_at(composition, window, kEye, {524 + 511.5, 14 + 300}), (PixelOfEye{1, {511, 300}}));
  EXPECT_EQ(pixel_at(composition, window, kEye, {3.9, 14}), std::nullopt);
  EXPECT_EQ(pixel_at(composition, window, kEye, {520, 200}), std::nullopt) << "between the eyes";
  EXPECT_EQ(pixel_at(composition, window, kEye, {1100, 200}), std::nullopt) << "on the panel";
}

TEST(PixelAt, FollowsScaleAndLayout) {
  const Composition crossed{.layout = StereoLayout::CrossEyed};
  EXPECT_EQ(pixel_at(crossed, {512, 256}, kEye, {10.5, 100}), (PixelOfEye{1, {21, 200}}));
  const Composition anaglyph{.layout = StereoLayout::Anaglyph, .shared = {{40, 0}, 472}};
  EXPECT_EQ(pixel_at(anaglyph, {472, 512}, kEye, {7, 9}), (PixelOfEye{0, {47, 9}}));
  EXPECT_EQ(pixel_at(anaglyph, {}, kEye, {0, 0}), std::nullopt);
}

}  // namespace
}  // namespace farshade
