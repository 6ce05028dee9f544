#include "vr_client/report/measure.h"

#include <gtest/gtest.h>

namespace farshade {
namespace {

/// Four pixels in a row, as they were shown.
ShownReport shown(std::uint32_t lights, const std::array<std::uint8_t, 4>& sources) {
  return {EyeMask({4, 1}, lights), {sources.begin(), sources.end()}};
}

TEST(CompareMasks, EqualMasksHaveNoError) {
  ShownReport report = shown(3, {0, 0, 0, 0});
  report.mask.set_word(1, 0, 0, 5);
  const EyeErrors errors = compare_masks(report, report.mask);
  EXPECT_EQ(errors.mask_error, 0);
  EXPECT_EQ(errors.newest, 1);
  EXPECT_EQ(errors.older + errors.unknown, 0);
}

TEST(CompareMasks, CountsWrongPixelLightsOfCoveredPixels) {
  ShownReport report = shown(3, {0, 0, 1, kSourceUncovered});
  report.mask.set_word(0, 0, 0, 0b101);
  report.mask.set_word(1, 0, 0, 0b111);
  report.mask.set_word(3, 0, 0, 0b111);  // not covered: must not count
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

TEST(CompareMasks, UnknownCountsByTheRuleNotByItsBits) {
  constexpr double shown_k = kUnknownVisibility;
  ShownReport report = shown(2, {kSourceUnknown, kSourceUnknown, 0, 0});
  report.mask.set_word(0, 0, 0, 0b01);
  EyeMask reference({4, 1}, 2);
  reference.set_word(0, 0, 0, 0b01);  // one lit, one not
  reference.set_word(1, 0, 0, 0b11);
  const EyeErrors errors = compare_masks(report, reference);
  EXPECT_DOUBLE_EQ(errors.mask_error, (3 * (1 - shown_k) + shown_k) / 8);
  EXPECT_DOUBLE_EQ(errors.unknown, 0.5);
  EXPECT_DOUBLE_EQ(errors.newest, 0.5);
}

TEST(CompareMasks, FortyLightsLieInTwoPlanes) {
  ShownReport report = shown(40, {0, kSourceUnknown, kSourceUncovered, kSourceUncovered});
  report.mask.set_word(0, 0, 1, 0x81);
  EyeMask reference({4, 1}, 40);
  reference.set_word(0, 0, 0, 0x8000'0000u);
  reference.set_word(0, 0, 1, 0x80);
  const EyeErrors errors = compare_masks(report, reference);
  EXPECT_DOUBLE_EQ(errors.mask_error, (2 + 40 * double{kUnknownVisibility}) / 80)
      << "the unknown pixel is dark for all forty";
}

TEST(CompareMasks, NothingCoveredOrNoLightsIsNoError) {
  const auto u = kSourceUncovered;
  EXPECT_EQ(compare_masks(shown(3, {u, u, u, u}), EyeMask({4, 1}, 3)).mask_error, 0);
  EXPECT_EQ(compare_masks(shown(0, {0, 0, 0, 0}), EyeMask({4, 1}, 0)).mask_error, 0);
}

}  // namespace
}  // namespace farshade
