/// The bundled walk has the properties that its maker states.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "stereo/base/quantile.h"
#include "stereo/head/reader.h"
#include "tests/unit/head/head_speed.h"

namespace farshade {
namespace {

HeadRecording walk() {
  return load_head_recording(FARSHADE_ASSETS "/walk.csv").value();
}

TEST(BundledWalk, LastsTwentySecondsAtSeventyTwoHertz) {
  const HeadRecording recording = walk();
  EXPECT_EQ(recording.samples.size(), 20u * 72u + 1u);
  EXPECT_EQ(ns_of(recording.start()), 1'000'000'000'000);
  EXPECT_EQ(recording.end() - recording.start(), std::chrono::seconds(20));
  EXPECT_NE(recording.fov[0], recording.fov[1]);
}

TEST(BundledWalk, StartsCalmAndTurnsFastWithinFourSeconds) {
  const HeadRecording recording = walk();
  const auto speeds = [&](int s) {
    return turn_speeds_deg_s(recording, recording.start() + std::chrono::seconds(s));
  };
  EXPECT_LT(quantile(speeds(1), 1.0), 60.0);
  EXPECT_GT(quantile(speeds(4), 1.0), 150.0);
  EXPECT_LT(quantile(speeds(20), 1.0), 250.0);
}

TEST(BundledWalk, StaysInTheRoomsFreeStrip) {
  const HeadRecording recording = walk();
  // The reference camera of room.glb. The strip around it is free of furniture by 0.4 m.
  const Rigid<Stage, Eye> camera{rotation_exp({0, std::atan2(1.2, 2.75), 0}), {0.95, 1.6, 1.75}};
  const auto stage_from_recorded = place(recording, camera);
  glm::dvec3 low(1e9), high(-1e9);
  for (const HeadSample& sample : recording.samples) {
    const Rigid<Stage, Head> head = stage_from_recorded * sample.recorded_from_head;
    low = glm::min(low, head.translation);
    high = glm::max(high, head.translation);
  }
  EXPECT_TRUE(low.x > -0.9 && high.x < 2.1 && low.z > 0.4 && high.z < 2.0)
      << low.x << ' ' << high.x << ' ' << high.z;
  EXPECT_TRUE(low.y > 1.5 && high.y < 1.7);
  EXPECT_GT(high.x - low.x, 1.0) << "the head walks";
}

}  // namespace
}  // namespace farshade
