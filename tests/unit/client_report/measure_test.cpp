#include "vr_client/report/measure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "stereo/metrics/pixels_per_degree.h"

namespace farshade {
namespace {

/// Four pixels in a row. Nothing is lit, unknown or stale, except that pixels without a source are unknown
/// and shown by the rule for unknown bits.
ShownReport shown(std::uint32_t lights, const std::array<std::uint8_t, 4>& sources) {
  const std::size_t planes = MaskLayout{lights}.planes();
  ShownReport report{.mask = EyeMask({4, 1}, lights),
                     .sources = {sources.begin(), sources.end()},
                     .positions = {},
                     .visibility = std::vector<std::uint8_t>(std::size_t{4} * lights),
                     .unknown = std::vector<std::uint32_t>(std::size_t{4} * planes),
                     .stale = std::vector<std::uint32_t>(std::size_t{4} * planes)};
  for (std::size_t pixel = 0; pixel < 4; ++pixel)
    for (std::uint32_t i = 0; i < lights && sources[pixel] == kSourceUnknown; ++i) {
      report.visibility[pixel * lights + i] =
          static_cast<std::uint8_t>(std::lround(255 * kUnknownVisibility));
      report.unknown[pixel * planes + i / 32] |= 1u << i % 32;
    }
  return report;
}

/// Pixel `x` shows the lights of `bits` fully and the others not at all.
void light_up(ShownReport& report, std::uint32_t x, std::uint32_t plane, std::uint32_t bits) {
  report.mask.set_word(x, 0, plane, bits);
  const std::uint32_t lights = report.mask.lights();
  for (std::uint32_t i = plane * 32; i < std::min(lights, plane * 32 + 32); ++i)
    report.visibility[x * lights + i] = bits >> i % 32 & 1u ? 255 : 0;
}

double sum_of_shares(const EyeErrors& e) {
  return e.newest + e.other_eye + e.older + e.cube_mask + e.neighbours + e.own_rays + e.unknown;
}

TEST(OtherSurface, CountsPixelsThatOneAloneCoversOrThatAreElsewhere) {
  const Extent size{2, 2};
  Image<float> drawn(size, 1.0f), traced(size, 1.0f);
  EXPECT_EQ(other_surface_share(drawn, traced), 0);
  traced.at(0, 0) = 1.009f;
  EXPECT_EQ(other_surface_share(drawn, traced), 0) << "rounding, and slopes";
  traced.at(0, 0) = 1.02f;
  EXPECT_EQ(other_surface_share(drawn, traced), 0.25);
  traced.at(1, 0) = 0;
  EXPECT_EQ(other_surface_share(drawn, traced), 0.5);
  drawn.at(0, 1) = 0;
  EXPECT_EQ(other_surface_share(drawn, traced), 0.75);
  drawn.at(1, 0) = drawn.at(0, 0) = traced.at(0, 0) = traced.at(0, 1) = 0;
  EXPECT_EQ(other_surface_share(drawn, traced), 0) << "nothing is the same as nothing";
}

TEST(CompareMasks, EqualMasksHaveNoError) {
  ShownReport report = shown(3, {0, 0, 0, 0});
  light_up(report, 1, 0, 5);
  const EyeErrors errors = compare_masks(report, report.mask);
  EXPECT_EQ(errors.mask_error, 0);
  EXPECT_EQ(errors.known_error, 0);
  EXPECT_EQ(errors.newest, 1);
  EXPECT_EQ(errors.other_eye + errors.older + errors.neighbours + errors.unknown + errors.stale, 0);
}

TEST(CompareMasks, CountsWrongPixelLightsOfCoveredPixels) {
  ShownReport report = shown(3, {0, 0, 1, kSourceUncovered});
  light_up(report, 0, 0, 0b101);
  light_up(report, 1, 0, 0b111);
  light_up(report, 3, 0, 0b111);  // not covered: must not count
  EyeMask reference({4, 1}, 3);
  reference.set_word(0, 0, 0, 0b001);  // one wrong
  reference.set_word(1, 0, 0, 0b000);  // three wrong
  reference.set_word(2, 0, 0, 0b010);  // one wrong
  const EyeErrors errors = compare_masks(report, reference);
  EXPECT_DOUBLE_EQ(errors.mask_error, 5.0 / 9);
  EXPECT_DOUBLE_EQ(errors.newest, 2.0 / 3);
  EXPECT_DOUBLE_EQ(errors.older, 1.0 / 3);
  EXPECT_EQ(errors.unknown, 0);
}

TEST(CompareMasks, AFractionCountsByItsDifference) {
  ShownReport report = shown(1, {0, 0, 0, 0});
  report.visibility = {51, 51, 255, 0};
  EyeMask reference({4, 1}, 1);
  reference.set_word(0, 0, 0, 1);  // 0.8 wrong; the second pixel 0.2
  reference.set_word(2, 0, 0, 1);
  EXPECT_DOUBLE_EQ(compare_masks(report, reference).mask_error, (0.8 + 0.2) / 4);
}

TEST(CompareMasks, UnknownCountsWithItsShownVisibility) {
  constexpr double shown_k = kUnknownVisibility;
  const ShownReport report = shown(2, {kSourceUnknown, kSourceUnknown, 0, 0});
  EyeMask reference({4, 1}, 2);
  reference.set_word(0, 0, 0, 0b01);  // one lit, one not
  reference.set_word(1, 0, 0, 0b11);
  reference.set_word(2, 0, 0, 0b10);  // known, and wrong
  const EyeErrors errors = compare_masks(report, reference);
  EXPECT_DOUBLE_EQ(errors.mask_error, (3 * (1 - shown_k) + shown_k + 1) / 8);
  EXPECT_DOUBLE_EQ(errors.known_error, 1.0 / 4) << "one of four known ones";
  EXPECT_DOUBLE_EQ(errors.unknown, 0.5);
  EXPECT_DOUBLE_EQ(errors.newest, 0.5);
}

TEST(CompareMasks, APixelMayKnowSomeOfItsLights) {
  ShownReport report = shown(4, {1, kSourceUncovered, kSourceUncovered, kSourceUncovered});
  report.unknown[0] = 0b0011;
  report.stale[0] = 0b1000;
  report.visibility = {255, 255, 0, 0};
  report.visibility.resize(16);
  const EyeErrors errors = compare_masks(report, EyeMask({4, 1}, 4));
  EXPECT_DOUBLE_EQ(errors.older, 0.5);
  EXPECT_DOUBLE_EQ(errors.unknown, 0.5);
  EXPECT_DOUBLE_EQ(errors.stale, 0.25);
  EXPECT_DOUBLE_EQ(errors.mask_error, 0.5);
  EXPECT_EQ(errors.known_error, 0);
}

TEST(CompareMasks, EverySourceHasItsShareAndTheyAddUpToOne) {
  const EyeErrors four =
      compare_masks(shown(3, {kFirstFace + 5, kOtherEye, kOtherEye + 2, kNeighbour}), EyeMask({4, 1}, 3));
  EXPECT_DOUBLE_EQ(four.cube_mask, 0.25);
  EXPECT_DOUBLE_EQ(four.other_eye, 0.25);
  EXPECT_DOUBLE_EQ(four.older, 0.25) << "the other eye's older mask";
  EXPECT_DOUBLE_EQ(four.neighbours, 0.25);
  EXPECT_EQ(four.unknown, 0);

  std::mt19937 random(31);  // the seed
  const std::array<std::uint8_t, 10> sources{0,
                                             1,
                                             3,
                                             kOtherEye,
                                             kOtherEye + 3,
                                             kFirstFace,
                                             kFirstFace + 3,
                                             kNeighbour,
                                             kSourceUnknown,
                                             kSourceUncovered};
  for (int i = 0; i < 200; ++i) {
    const std::uint32_t lights = 1 + static_cast<std::uint32_t>(random()) % 40;
    const auto any = [&] { return sources[random() % sources.size()]; };
    ShownReport report = shown(lights, {0, any(), any(), any()});
    for (std::uint32_t light = 0; light < lights; ++light)
      if (random() % 3 == 0) report.unknown[light / 32] |= 1u << light % 32;
    EXPECT_NEAR(sum_of_shares(compare_masks(report, EyeMask({4, 1}, lights))), 1, 1e-12) << "case " << i;
  }
}

TEST(CompareMasks, FortyLightsLieInTwoPlanes) {
  ShownReport report = shown(40, {0, kSourceUnknown, kSourceUncovered, kSourceUncovered});
  light_up(report, 0, 1, 0x81);
  report.stale[1] = 0x3;
  EyeMask reference({4, 1}, 40);
  reference.set_word(0, 0, 0, 0x8000'0000u);
  reference.set_word(0, 0, 1, 0x80);
  const EyeErrors errors = compare_masks(report, reference);
  EXPECT_DOUBLE_EQ(errors.mask_error, (2 + 40 * double{kUnknownVisibility}) / 80)
      << "the unknown pixel is dark for all forty";
  EXPECT_DOUBLE_EQ(errors.stale, 2.0 / 80);
}

TEST(CompareMasks, TellsHowMuchOfTheEyeShowsASurface) {
  const auto u = kSourceUncovered;
  EXPECT_DOUBLE_EQ(compare_masks(shown(3, {0, u, kSourceUnknown, 0}), EyeMask({4, 1}, 3)).covered, 0.75);
  EXPECT_EQ(compare_masks(shown(3, {u, u, u, u}), EyeMask({4, 1}, 3)).covered, 0);
}

TEST(CompareMasks, HasNoErrorWithoutCoveredPixelsOrLights) {
  const auto u = kSourceUncovered;
  EXPECT_EQ(compare_masks(shown(3, {u, u, u, u}), EyeMask({4, 1}, 3)).mask_error, 0);
  EXPECT_EQ(compare_masks(shown(0, {0, 0, 0, 0}), EyeMask({4, 1}, 0)).mask_error, 0);
}

TEST(UnmovedError, ReadsTheStaleMaskAtTheShownPixels) {
  const ShownReport report = shown(2, {0, kSourceUnknown, kSourceUncovered, kNeighbour});
  EyeMask stale({4, 1}, 2), reference({4, 1}, 2);
  stale.set_word(0, 0, 0, 0b11);  // one wrong
  reference.set_word(0, 0, 0, 0b01);
  stale.set_word(1, 0, 0, 0b10);  // right, although it was shown differently
  reference.set_word(1, 0, 0, 0b10);
  reference.set_word(2, 0, 0, 0b11);  // not covered
  reference.set_word(3, 0, 0, 0b11);  // two wrong
  EXPECT_DOUBLE_EQ(unmoved_error(stale, {0, 0}, report, reference), 3.0 / 6);
}

TEST(UnmovedError, SkipsTheGuardBand) {
  const ShownReport report = shown(2, {0, 0, 0, 0});
  EyeMask reference({4, 1}, 2), wide({7, 3}, 2);
  for (std::uint32_t x = 0; x < 4; ++x) {
    reference.set_word(x, 0, 0, x);
    wide.set_word(x + 2, 1, 0, x);
  }
  EXPECT_EQ(unmoved_error(wide, {2, 1}, report, reference), 0);
  EXPECT_GT(unmoved_error(wide, {1, 1}, report, reference), 0);
  EXPECT_GT(unmoved_error(wide, {2, 0}, report, reference), 0);
}

TEST(UnmovedError, CountsPixelsOutsideAsUnknown) {
  const ShownReport report = shown(3, {0, 0, 0, 0});
  EyeMask reference({4, 1}, 3);
  reference.set_word(0, 0, 0, 0b001);  // outside: one lit, two dark
  const EyeMask stale({4, 1}, 3);
  constexpr double k = kUnknownVisibility;
  EXPECT_DOUBLE_EQ(unmoved_error(stale, {-1, 0}, report, reference), ((1 - k) + 2 * k) / 12);
  reference.set_word(0, 0, 0, 0);
  EXPECT_DOUBLE_EQ(unmoved_error(stale, {1, 0}, report, reference), 3 * k / 12) << "beyond the right border";
  EXPECT_DOUBLE_EQ(unmoved_error(stale, {0, 1}, report, reference), k) << "all pixels are below the border";
}

TEST(PixelsPerDegree, IsThatOfTheMiddleOfTheView) {
  const double half = std::atan(1.0);
  EXPECT_NEAR(pixels_per_degree({{}, {-half, half, half, -half}, {1000, 1000}}), 500 * std::numbers::pi / 180,
              1e-9);
  EXPECT_NEAR(pixels_per_degree({{}, {-half, half, half, -half}, {1000, 4000}}),
              1000 * std::numbers::pi / 180, 1e-9)
      << "the geometric mean of both axes";
}

}  // namespace
}  // namespace farshade
