#include "stereo/requests/guard_band.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "stereo/math/rotation.h"
#include "stereo/raster/frame_data.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr double kHalf = 0.7, kHalfUp = 0.6;  ///< radians
constexpr Extent kSize{512, 400};
const View kView{{{1, 0, 0, 0}, {0.3, 1.6, -0.2}}, {-kHalf, kHalf, kHalfUp, -kHalfUp}, kSize};

View moved(const View& view, const glm::dvec3& turn, const glm::dvec3& step) {
  View result = view;
  result.stage_from_eye = view.stage_from_eye * Rigid<Eye, Eye>{rotation_exp(turn), step};
  return result;
}

StereoView both(const View& view) {
  return {view, view};
}

void expect_near(const Sides<double>& found, const Sides<double>& expected, double tolerance) {
  EXPECT_NEAR(found.left, expected.left, tolerance);
  EXPECT_NEAR(found.right, expected.right, tolerance);
  EXPECT_NEAR(found.up, expected.up, tolerance);
  EXPECT_NEAR(found.down, expected.down, tolerance);
}

TEST(OutsidePx, IsZeroForTheSameView) {
  expect_near(outside_px(kView, kView), {0, 0, 0, 0}, 1e-9);
}

TEST(OutsidePx, IsClosedFormForAYaw) {
  const double per_x = kSize.width / (2 * std::tan(kHalf)), per_y = kSize.height / (2 * std::tan(kHalfUp));
  for (const double a : {0.001, 0.02, 0.3}) {
    // The left border is at the angle half + a. Its corners are also further from the middle row.
    const double ahead = (std::tan(kHalf + a) - std::tan(kHalf)) * per_x,
                 behind = (std::tan(kHalf - a) - std::tan(kHalf)) * per_x,
                 corner = std::tan(kHalfUp) * (std::cos(kHalf) / std::cos(kHalf + a) - 1) * per_y;
    expect_near(outside_px(moved(kView, {0, a, 0}, {}), kView), {ahead, behind, corner, corner}, 1e-8);
    expect_near(outside_px(moved(kView, {0, -a, 0}, {}), kView), {behind, ahead, corner, corner}, 1e-8);
  }
}

TEST(OutsidePx, IsClosedFormForAPitch) {
  const double per_x = kSize.width / (2 * std::tan(kHalf)), per_y = kSize.height / (2 * std::tan(kHalfUp));
  constexpr double a = 0.05;
  const double ahead = (std::tan(kHalfUp + a) - std::tan(kHalfUp)) * per_y,
               behind = (std::tan(kHalfUp - a) - std::tan(kHalfUp)) * per_y,
               corner = std::tan(kHalf) * (std::cos(kHalfUp) / std::cos(kHalfUp + a) - 1) * per_x;
  expect_near(outside_px(moved(kView, {a, 0, 0}, {}), kView), {corner, corner, ahead, behind}, 1e-8);
}

TEST(OutsidePx, IsClosedFormForAStepBesideTheNearestSurface) {
  const double per_x = kSize.width / (2 * std::tan(kHalf)), per_y = kSize.height / (2 * std::tan(kHalfUp));
  expect_near(outside_px(moved(kView, {}, {0.1, 0, 0}), kView), {0, 0.1 / kNearest_m * per_x, 0, 0}, 1e-8);
  expect_near(outside_px(moved(kView, {}, {0, -0.04, 0}), kView), {0, 0, 0, 0.04 / kNearest_m * per_y}, 1e-8);
  // A head that moved forwards: the border of the shown view lies inside the traced view, except for
  // infinitely distant surfaces.
  expect_near(outside_px(moved(kView, {}, {0, 0, -0.2}), kView), {0, 0, 0, 0}, 1e-8);
  // A head that moved backwards: a point that is now 1 m ahead is 0.8 m ahead of the traced eye.
  expect_near(outside_px(moved(kView, {}, {0, 0, 0.2}), kView),
              {256 / 0.8 - 256, 256 / 0.8 - 256, 200 / 0.8 - 200, 200 / 0.8 - 200}, 1e-8);
}

TEST(OutsidePx, StaysFiniteForAnyPose) {
  std::mt19937_64 random(3);  // the seed
  std::uniform_real_distribution<double> any(-3.2, 3.2);
  for (int i = 0; i < 2000; ++i) {
    const View shown = moved(kView, {any(random), any(random), any(random)}, {any(random), 0, any(random)});
    const Sides<double> out = outside_px(shown, kView);
    for (const double side : {out.left, out.right, out.up, out.down})
      ASSERT_TRUE(std::isfinite(side) && std::abs(side) < 1e5) << "case " << i;
  }
}

TEST(Widened, KeepsThePixelGrid) {
  std::mt19937_64 random(4);  // the seed
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
  };
  for (int i = 0; i < 2000; ++i) {
    const auto any_px = [&] { return static_cast<std::uint32_t>(random() % 300); };
    const View view{{rotation_exp({between(-2, 2), between(-2, 2), 0}), {1, 2, 3}},
                    {between(-1.4, -0.01), between(0.01, 1.4), between(0.01, 1.4), between(-1.4, -0.01)},
                    {1 + any_px() * 6, 1 + any_px() * 6}};
    const Sides<std::uint32_t> margins{any_px(), any_px(), any_px(), any_px()};
    const View wide = widened(view, margins);
    ASSERT_EQ(wide.stage_from_eye, view.stage_from_eye);
    ASSERT_EQ(wide.size, (Extent{view.size.width + margins.left + margins.right,
                                 view.size.height + margins.up + margins.down}));
    ASSERT_EQ(grid_offset_px(view, wide), glm::ivec2(margins.left, margins.up)) << "case " << i;
    ASSERT_TRUE(shares_pixels(view, wide)) << "case " << i;
    const glm::dvec3 ray = pixel_ray(tangents_of(view.fov), view.size, {0.5, 0.5});
    const glm::dvec2 there = ray_pixel(tangents_of(wide.fov), wide.size, ray);
    ASSERT_LT(glm::length(there - glm::dvec2(margins.left + 0.5, margins.up + 0.5)), 1e-6) << "case " << i;
  }
}

TEST(Widened, ByNothingIsTheSameViewButForRounding) {
  const View same = widened(kView, {});
  EXPECT_EQ(same.size, kView.size);
  EXPECT_NEAR(same.fov.left_rad, kView.fov.left_rad, 1e-15);
  EXPECT_NEAR(same.fov.up_rad, kView.fov.up_rad, 1e-15);
}

TEST(SharesPixels, IsFalseForAnotherPoseOrGrid) {
  EXPECT_TRUE(shares_pixels(kView, kView));
  EXPECT_FALSE(shares_pixels(kView, moved(kView, {0, 1e-9, 0}, {})));
  EXPECT_FALSE(shares_pixels(kView, moved(kView, {}, {0, 1e-6, 0})));
  View finer = kView;
  finer.size.width += 1;
  EXPECT_FALSE(shares_pixels(kView, finer));
  View half = kView;  // moved to the side by half a pixel
  const double step = 2 * std::tan(kHalf) / kSize.width;
  half.fov.left_rad = std::atan(-std::tan(kHalf) + step / 2);
  half.fov.right_rad = std::atan(std::tan(kHalf) + step / 2);
  EXPECT_FALSE(shares_pixels(kView, half));
}

Sides<std::uint32_t> margins_of(const GuardBand& band, const Twist& velocity = {}, Duration lead = 50ms,
                                Duration spread = {}) {
  return band.margins_px(both(kView), velocity, lead, spread);
}

TEST(GuardBand, IsZeroAtFirst) {
  EXPECT_EQ(margins_of(GuardBand{}), (Sides<std::uint32_t>{}));
  EXPECT_EQ(margins_of(GuardBand{}, {}, 50ms, 50ms), (Sides<std::uint32_t>{})) << "a head at rest";
}

TEST(GuardBand, IsAsWideAsItIsAskedToBe) {
  GuardBand band;
  band.observe(both(moved(kView, {}, {0, 0.05, 0})), both(kView));
  const auto all = [&](double share) {
    const auto margins = band.margins_px(both(kView), {.angular = {0, 0.4, 0}}, 50ms, 20ms, share);
    return margins.left + margins.right;
  };
  EXPECT_EQ(all(0), 0u);
  EXPECT_GT(all(1), 0u);
  EXPECT_GT(all(4), all(1));
  EXPECT_LE(all(100), largest_traced(kSize).width - kSize.width);
}

TEST(GuardBand, IsZeroIfPredictionsWereRight) {
  std::mt19937_64 random(6);  // the seed
  std::uniform_real_distribution<double> any(-2, 2);
  for (int i = 0; i < 300; ++i) {
    View view = moved(kView, {any(random), any(random), any(random)}, {any(random), 0, any(random)});
    view.fov.left_rad -= 0.1 * std::abs(any(random));
    view.fov.down_rad -= 0.1 * std::abs(any(random));
    GuardBand band;
    band.observe(both(view), both(view));
    ASSERT_EQ(band.margins_px(both(view), {}, 50ms, {}), (Sides<std::uint32_t>{})) << "case " << i;
  }
}

TEST(GuardBand, GrowsOnTheSidesThatNeedItOnly) {
  const double per_x = kSize.width / (2 * std::tan(kHalf)), per_y = kSize.height / (2 * std::tan(kHalfUp));
  const auto in_steps = [](double px) {
    return static_cast<std::uint32_t>(std::ceil(px / GuardBand::kStep_px)) * GuardBand::kStep_px;
  };
  struct Case {
    glm::dvec3 step;
    Sides<std::uint32_t> expected;
  };
  for (const Case& c : {Case{{0.1, 0, 0}, {.right = in_steps(0.1 * per_x)}},
                        Case{{-0.1, 0, 0}, {.left = in_steps(0.1 * per_x)}},
                        Case{{0, 0.06, 0}, {.up = in_steps(0.06 * per_y)}},
                        Case{{0, -0.06, 0}, {.down = in_steps(0.06 * per_y)}}}) {
    GuardBand band;
    for (int i = 0; i < 20; ++i) band.observe(both(moved(kView, {}, c.step)), both(kView));
    EXPECT_EQ(margins_of(band), c.expected) << c.step.x << " " << c.step.y;
  }
}

TEST(GuardBand, TakesTheWorseEye) {
  GuardBand band;
  band.observe({kView, moved(kView, {}, {0.1, 0, 0})}, both(kView));
  EXPECT_GT(margins_of(band).right, 0u);
  GuardBand other;
  other.observe({moved(kView, {}, {0.1, 0, 0}), kView}, both(kView));
  EXPECT_EQ(margins_of(other), margins_of(band));
}

TEST(GuardBand, ForgetsOutliersAndThePast) {
  GuardBand band;
  for (int i = 0; i < 100; ++i)
    band.observe(both(i == 50 ? moved(kView, {}, {0.1, 0, 0}) : kView), both(kView));
  EXPECT_EQ(margins_of(band), (Sides<std::uint32_t>{})) << "one in a hundred is beyond the quantile";
  for (int i = 0; i < 200; ++i) band.observe(both(moved(kView, {}, {0.1, 0, 0})), both(kView));
  EXPECT_GT(margins_of(band).right, 0u);
  for (int i = 0; i < 200; ++i) band.observe(both(kView), both(kView));
  EXPECT_EQ(margins_of(band), (Sides<std::uint32_t>{})) << "three seconds later";
}

TEST(GuardBand, HoldsNineteenFramesOutOfTwenty) {
  const auto right_after = [](int wrong) {
    GuardBand band;
    for (int i = 0; i < 100; ++i)
      band.observe(both(i < wrong ? moved(kView, {}, {0.1, 0, 0}) : kView), both(kView));
    return margins_of(band).right;
  };
  EXPECT_EQ(right_after(4), 0u);
  EXPECT_GT(right_after(7), 0u);
}

TEST(GuardBand, WidensTheAxisOfATurn) {
  const Twist yaw{{0, 2, 0}, {}}, pitch{{-2, 0, 0}, {}};
  const Sides<std::uint32_t> turning = margins_of({}, yaw), nodding = margins_of({}, pitch);
  EXPECT_GT(turning.left, 0u);
  EXPECT_EQ(turning.left, turning.right) << "the head may also stop";
  EXPECT_EQ(turning.up + turning.down, 0u);
  EXPECT_EQ(nodding.left + nodding.right, 0u);
  EXPECT_GT(nodding.up, 0u);
  EXPECT_GE(margins_of({}, yaw, 100ms).left, turning.left) << "a longer lead";
  EXPECT_GT(margins_of({}, yaw, 50ms, 50ms).left, turning.left) << "masks used for longer";
  EXPECT_EQ(margins_of({}, yaw, 0ms), (Sides<std::uint32_t>{}));
}

/// Pixels per radian at the border of kView, along each axis: width / (2 tan a) * (1 + tan^2 a).
double pixels_per_rad(double pixels, double half_rad) {
  const double edge = std::tan(half_rad);
  return pixels / (2 * edge) * (1 + edge * edge);
}

TEST(GuardBand, AddsFifteenPercentOfTheTurnWithinTheLead) {
  const double per_yaw = pixels_per_rad(kSize.width, kHalf),
               per_pitch = pixels_per_rad(kSize.height, kHalfUp);
  for (const double px : {15.9, 16.1, 31.9, 32.1}) {
    const std::uint32_t expected = px < 16 ? 16 : px < 32 ? 32 : 48;
    const double yaw = px / (0.15 * 0.05 * per_yaw), pitch = px / (0.15 * 0.05 * per_pitch);
    EXPECT_EQ(margins_of({}, {{0, yaw, 0}, {}}).left, expected) << px;
    EXPECT_EQ(margins_of({}, {{0, -yaw, 0}, {}}).right, expected) << px;
    EXPECT_EQ(margins_of({}, {{pitch, 0, 0}, {}}).up, expected) << px;
    EXPECT_EQ(margins_of({}, {{-pitch, 0, 0}, {}}).down, expected) << px;
  }
}

TEST(GuardBand, AddsTheTurnWithinTheSpreadUnlessTheMeasurementHoldsIt) {
  const double per_yaw = pixels_per_rad(kSize.width, kHalf);
  const Twist velocity{{0, 31 / (0.02 * per_yaw), 0}, {}};  // 31 px in 20 ms
  EXPECT_EQ(margins_of({}, velocity, 0ms, 20ms).left, 32u);
  EXPECT_EQ(margins_of({}, velocity, 0ms, 21ms).left, 48u);
  GuardBand band;
  const double per_x = kSize.width / (2 * std::tan(kHalf));
  band.observe(both(moved(kView, {}, {40 / per_x * kNearest_m, 0, 0})), both(kView));  // 40 px on the right
  EXPECT_EQ(margins_of(band, velocity, 0ms, 20ms).left, 32u);
  EXPECT_EQ(margins_of(band, velocity, 0ms, 20ms).right, 48u) << "not the sum of both";
}

TEST(ReducedToFit, LeavesWhatFits) {
  const Sides<std::uint32_t> margins{16, 32, 48, 0};
  const std::uint64_t pixels = widened(kView, margins).size.pixels();
  EXPECT_EQ(reduced_to_fit(both(kView), margins, pixels), margins);
  EXPECT_NE(reduced_to_fit(both(kView), margins, pixels - 1), margins);
}

TEST(ReducedToFit, GivesStepsToTheSideThatMissesMost) {
  const std::uint64_t most = widened(kView, {48, 0, 16, 0}).size.pixels();
  EXPECT_EQ(reduced_to_fit(both(kView), {64, 16, 32, 0}, most), (Sides<std::uint32_t>{48, 0, 16, 0}));
}

TEST(ReducedToFit, UsesAllThatTheLimitLeaves) {
  std::mt19937_64 random(8);  // the seed
  for (int i = 0; i < 500; ++i) {
    const auto any_px = [&] { return static_cast<std::uint32_t>(random() % 5) * GuardBand::kStep_px; };
    const Sides<std::uint32_t> needed{any_px(), any_px(), any_px(), any_px()};
    const std::uint64_t most = kSize.pixels() + random() % (kSize.pixels() / 3);
    const Sides<std::uint32_t> fitted = reduced_to_fit(both(kView), needed, most);
    ASSERT_LE(widened(kView, fitted).size.pixels(), most) << "case " << i;
    using Margins = Sides<std::uint32_t>;
    for (const auto side : {&Margins::left, &Margins::right, &Margins::up, &Margins::down}) {
      Margins wider = fitted;
      wider.*side += GuardBand::kStep_px;
      ASSERT_TRUE(fitted.*side == needed.*side || widened(kView, wider).size.pixels() > most) << "case " << i;
    }
  }
}

TEST(ReducedToFit, NarrowsAnAxisAtItsLimitAlone) {
  View wide = kView;
  wide.size.width = kMaxViewSide_px - 40;
  const Sides<std::uint32_t> fitted = reduced_to_fit(both(wide), {32, 32, 48, 48}, ~0ull);
  EXPECT_EQ(fitted.left + fitted.right, 32u);
  EXPECT_EQ(fitted.up, 48u);
  EXPECT_EQ(fitted.down, 48u);
}

TEST(GuardBand, StaysWithinTheLargestTracedSizeInWholeSteps) {
  std::mt19937_64 random(5);  // the seed
  std::uniform_real_distribution<double> any(-1, 1);
  bool reached = false;
  for (int i = 0; i < 2000; ++i) {
    View view = kView;
    view.size = {1 + static_cast<std::uint32_t>(random() % 1500),
                 1 + static_cast<std::uint32_t>(random() % 1500)};
    GuardBand band;
    for (int k = 0; k < 3; ++k)
      band.observe(both(moved(view, {any(random), any(random), any(random)}, {any(random), any(random), 0})),
                   both(view));
    const Twist velocity{{20 * any(random), 20 * any(random), 0}, {}};
    const Sides<std::uint32_t> margins = band.margins_px(both(view), velocity, 100ms, 50ms);
    for (const std::uint32_t side : {margins.left, margins.right, margins.up, margins.down})
      ASSERT_EQ(side % GuardBand::kStep_px, 0u);
    const Extent wide = widened(view, margins).size, most = largest_traced(view.size);
    ASSERT_LE(wide.width, most.width) << "case " << i << ", of " << view.size.width;
    ASSERT_LE(wide.height, most.height) << "case " << i << ", of " << view.size.height;
    reached = reached || wide == most;
  }
  EXPECT_TRUE(reached);
  EXPECT_EQ(largest_traced({512, 256}), (Extent{640, 320})) << "a quarter larger";
  EXPECT_EQ(largest_traced({7000, 8192}), (Extent{8192, 8192})) << "but no larger than a view may be";
}

}  // namespace
}  // namespace farshade
