#include "vr_client/preview/layout.h"

#include <gtest/gtest.h>

namespace farshade {
namespace {

constexpr Extent kEye{320, 320};

TEST(TextScale, GrowsWithTheWindowInHalfSteps) {
  EXPECT_EQ(text_scale({1280, 720}, 1), 1);
  EXPECT_EQ(text_scale({1920, 1080}, 1), 1);
  EXPECT_EQ(text_scale({2560, 1440}, 1), 1.5);
  EXPECT_EQ(text_scale({3840, 2160}, 1), 2);
  EXPECT_EQ(text_scale({3840, 900}, 1), 1) << "the smaller side counts";
}

TEST(TextScale, IsAtLeastThatOfTheDesktopWithinItsLimits) {
  EXPECT_EQ(text_scale({1280, 720}, 2), 2);
  EXPECT_EQ(text_scale({1280, 720}, 1.3), 1.5);
  EXPECT_EQ(text_scale({3840, 2160}, 1.5), 2);
  EXPECT_EQ(text_scale({0, 0}, 0), 1);
  EXPECT_EQ(text_scale({60000, 60000}, 100), 4);
}

TEST(FirstWindow, HasRoomForBothEyesAndThePanel) {
  EXPECT_EQ(first_window(kEye, {{1920, 1080}, 1}, {}), (Extent{2 * 480 + 330, 720}));
  EXPECT_EQ(first_window({700, 800}, {{1920, 1080}, 1}, {}), (Extent{2 * 700 + 330, 800}));
  EXPECT_EQ(first_window(kEye, {{3840, 2160}, 1}, {}), (Extent{2 * (2 * 480 + 330), 2 * 720}));
}

TEST(FirstWindow, IsNeverLargerThanTheDesktop) {
  EXPECT_EQ(first_window({512, 512}, {{1280, 720}, 1}, {}), (Extent{1280, 720}));
  EXPECT_EQ(first_window({2048, 2048}, {{1366, 728}, 2}, {}), (Extent{1366, 728}));
  EXPECT_EQ(first_window(kEye, {{1280, 690}, 1}, Extent{3840, 2160}), (Extent{1280, 690}));
  EXPECT_EQ(first_window(kEye, {{200, 100}, 1}, {}), (Extent{200, 100}));
}

TEST(FirstWindow, HasTheRememberedSizeUnlessItIsTooSmall) {
  EXPECT_EQ(first_window(kEye, {{1920, 1080}, 2}, Extent{900, 500}), (Extent{900, 500}));
  EXPECT_EQ(first_window(kEye, {{1920, 1080}, 1}, Extent{1, 1}), kSmallestWindow);
}

}  // namespace
}  // namespace farshade
