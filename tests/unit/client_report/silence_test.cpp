#include "vr_client/report/silence.h"

#include <gtest/gtest.h>

namespace farshade {
namespace {

using namespace std::chrono_literals;

TEST(Silence, IsToldOnceAndItsEndOnce) {
  Silence silence("there:7447");
  EXPECT_FALSE(silence.add(FrameId{1}, {}, Time(1s)));
  const auto lost = silence.add(FrameId{2}, Time(2s), Time(4s));
  ASSERT_TRUE(lost);
  EXPECT_TRUE(lost->starts_with("frame 2: the server at there:7447 has sent nothing for 2.0 s.")) << *lost;
  EXPECT_FALSE(silence.add(FrameId{3}, Time(2s), Time(5s)));
  EXPECT_EQ(silence.time(), 3s);
  const auto back = silence.add(FrameId{4}, {}, Time(6s));
  ASSERT_TRUE(back);
  EXPECT_EQ(*back, "frame 4: the server at there:7447 answers after 4.0 s; 2 frames were shown meanwhile");
  EXPECT_FALSE(silence.add(FrameId{5}, {}, Time(7s)));
  EXPECT_TRUE(silence.add(FrameId{6}, Time(8s), Time(9s))) << "a second silence is told, too";
  EXPECT_EQ(silence.frames(), 3u);
  EXPECT_EQ(silence.time(), 5s);
}

TEST(Silence, FromTheBeginningIsKnownAndOnlyItsEndIsTold) {
  Silence silence("there:7447", true);
  EXPECT_FALSE(silence.add(FrameId{1}, Time(1s), Time(2s)));
  EXPECT_TRUE(silence.add(FrameId{2}, {}, Time(3s)));
  EXPECT_TRUE(silence.add(FrameId{3}, Time(4s), Time(5s)));
}

}  // namespace
}  // namespace farshade
