#include "stereo/frame/frame_id.h"

#include <gtest/gtest.h>

namespace farshade {
namespace {

TEST(FrameIdOrder, SurvivesWraparound) {
  const FrameId last{0xffffffff}, first{0}, second{1};
  EXPECT_TRUE(is_newer(first, last));
  EXPECT_TRUE(is_newer(second, last));
  EXPECT_FALSE(is_newer(last, first));
  EXPECT_EQ(next(last), first);
  EXPECT_EQ(next(next(last)), second);
  EXPECT_FALSE(is_newer(last, second));
}

TEST(FrameIdOrder, IsStrict) {
  EXPECT_FALSE(is_newer(FrameId{5}, FrameId{5}));
  EXPECT_TRUE(is_newer(FrameId{6}, FrameId{5}));
  EXPECT_FALSE(is_newer(FrameId{5}, FrameId{6}));
}

TEST(FrameIdOrder, ReachesHalfTheNumbers) {
  EXPECT_TRUE(is_newer(FrameId{0x7fffffff}, FrameId{0}));
  EXPECT_FALSE(is_newer(FrameId{0x80000001}, FrameId{0}));
}

}  // namespace
}  // namespace farshade
