#include "stereo/requests/cube_mask_plan.h"

#include <gtest/gtest.h>

#include "stereo/head/head_recording.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr Duration kFrame(13'888'889);

FrameMoment shown_at(Duration at, double x_m = 0, double eye_distance_m = 0.06) {
  FrameMoment shown;
  shown.frame = {1};
  shown.display_time = Time(at);
  shown.scene_time = Time(at + 5s);
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    shown.views[eye] = {{{}, {x_m + (static_cast<double>(eye) - 0.5) * eye_distance_m, 1.5, 0}},
                        {-0.7, 0.7, 0.7, -0.7},
                        {256, 256}};
  return shown;
}

struct Bench {
  CubeMaskPlan plan;
  SceneMotion motion = SceneMotion::Still;
  bool is_under_way = false;
  std::vector<FrameRequest> ask(const FrameMoment& shown) {
    return plan.ask(shown, 100ms, SceneClock::Running, motion, is_under_way);
  }
  /// Asks in each frame of a time. The times at which a cube mask began.
  std::vector<Duration> begun(Duration from, Duration until, double speed_m_s = 0,
                              double eye_distance_m = 0.06) {
    std::vector<Duration> result;
    for (Duration at = from; at < until; at += kFrame) {
      const auto requests = ask(shown_at(at, speed_m_s * seconds_of(at), eye_distance_m));
      if (!requests.empty() && pair_of(requests[0].frame) == 0) result.push_back(at);
    }
    return result;
  }
};

TEST(CubeMaskPlan, AsksForAllPairsAtOnceBeforeThereIsAny) {
  Bench bench;
  const std::vector<FrameRequest> requests = bench.ask(shown_at(0s, 0.5));
  ASSERT_EQ(requests.size(), kCubeMaskPairs);
  EXPECT_TRUE(bench.plan.is_urgent());
  for (std::size_t pair = 0; pair < kCubeMaskPairs; ++pair) {
    EXPECT_EQ(pair_of(requests[pair].frame), pair);
    EXPECT_EQ(requests[pair].views, faces_about({{0.5, 1.5, 0}}, pair, face_size({256, 256})));
    EXPECT_EQ(requests[pair].display_time, Time(100ms));
    EXPECT_EQ(requests[pair].scene_time, Time(5s + 100ms));
    EXPECT_EQ(requests[pair].answer, (AnswerSpec{.kind = Answer::CubeMask}));
  }
  EXPECT_TRUE(bench.ask(shown_at(kFrame)).empty());
}

TEST(CubeMaskPlan, AsksForOnePairAFrameLaterAllOfOnePlace) {
  Bench bench;
  EXPECT_EQ(bench.ask(shown_at(0s)).size(), kCubeMaskPairs);
  for (std::size_t pair = 0; pair < kCubeMaskPairs; ++pair) {
    const double x_m = 0.01 * static_cast<double>(pair);
    const std::vector<FrameRequest> requests =
        bench.ask(shown_at(CubeMaskPlan::kStillPeriod + kFrame * static_cast<int>(pair), x_m));
    ASSERT_EQ(requests.size(), 1u);
    EXPECT_FALSE(bench.plan.is_urgent());
    EXPECT_EQ(requests[0].views, faces_about({{0, 1.5, 0}}, pair, face_size({256, 256})));
  }
  EXPECT_TRUE(bench.ask(shown_at(CubeMaskPlan::kStillPeriod + 3 * kFrame)).empty());
}

TEST(CubeMaskPlan, AsksMoreOftenWhereSomethingMoves) {
  Bench still, moving;
  moving.motion = SceneMotion::Moving;
  EXPECT_EQ(still.begun(0s, 8s).size(), 4u);
  EXPECT_FALSE(still.plan.is_urgent());
  EXPECT_NEAR(static_cast<double>(moving.begun(0s, 4s).size()), 12, 1);
}

TEST(CubeMaskPlan, AsksSoonerWhenTheHeadHasMovedAway) {
  Bench walking;
  EXPECT_NEAR(static_cast<double>(walking.begun(0s, 4s, 1.0).size()), 4 / 0.24, 2) << "each 4 eye distances";
  Bench running;
  EXPECT_LE(running.begun(0s, 4s, 10.0).size(), 41u) << "not more than 10 a second";
}

TEST(CubeMaskPlan, FollowsAHeadWhoseEyesAreAtOnePlaceAsOneWithUsualEyes) {
  Bench one_place, usual;
  EXPECT_EQ(one_place.begun(0s, 4s, 1.0, 0), usual.begun(0s, 4s, 1.0, kDefaultEyeDistance_m));
  EXPECT_GT(one_place.begun(4s, 5s, 1.0, 0).size(), 2u);
}

TEST(CubeMaskPlan, AsksForAllPairsAtOnceAfterAJump) {
  Bench bench;
  bench.begun(0s, 500ms);
  EXPECT_EQ(bench.ask(shown_at(500ms, 2.5)).size(), kCubeMaskPairs);
  EXPECT_TRUE(bench.plan.is_urgent());
}

TEST(CubeMaskPlan, WaitsForTheLastOneButNotForever) {
  Bench bench;
  bench.motion = SceneMotion::Moving;
  bench.is_under_way = true;
  EXPECT_EQ(bench.begun(0s, 8s).size(), 4u) << "what has not come by then is lost";
}

TEST(CubeMaskPlan, AsksAgainAtOnceWhenTheLightsChange) {
  Bench bench;
  bench.begun(0s, 500ms);
  FrameMoment changed = shown_at(500ms);
  changed.lights.revision = {7};
  EXPECT_EQ(bench.ask(changed).size(), kCubeMaskPairs);
  // A light that is dragged changes in every frame.
  changed.lights.revision = {8};
  changed.display_time += kFrame;
  EXPECT_TRUE(bench.ask(changed).empty());
  changed.display_time += CubeMaskPlan::kLeastPeriod;
  bench.is_under_way = true;
  EXPECT_TRUE(bench.ask(changed).empty()) << "its answer would never find its record";
  bench.is_under_way = false;
  EXPECT_EQ(bench.ask(changed).size(), kCubeMaskPairs);
  EXPECT_TRUE(bench.plan.is_urgent());
}

}  // namespace
}  // namespace farshade
