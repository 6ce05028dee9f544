#include "stereo/requests/request_plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>

#include "stereo/math/rotation.h"

#include "stereo/raster/frame_data.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr Duration kPeriod = 10ms;
constexpr Extent kShownSize{320, 256};
const Rigid<Stage, Head> kStart{rotation_exp({0.1, 0.4, -0.05}), {1, 1.6, -2}};
const Twist kScrew{{0.1, 1.5, -0.05}, {0.3, 0, -0.4}};

/// Eyes at a distance from each other, both canted outwards by the same angle.
Rigid<Head, Eye> head_from(Side side) {
  const double sign = side == Side::Left ? -1 : 1;
  return {rotation_exp({0, -0.08 * sign, 0}), {0.032 * sign, 0, -0.01}};
}

StereoView views_of(const Rigid<Stage, Head>& head) {
  StereoView views;
  for (const Side side : kSides)
    views[index_of(side)] = {head * head_from(side), {-0.8, 0.7, 0.6, -0.65}, kShownSize};
  return views;
}

Rigid<Stage, Head> head_at(Duration time, const Twist& twist = kScrew) {
  return kStart * motion_exp<Head>(twist * seconds_of(time));
}

/// The views of frame `i` of a head that moves with `twist`. The scene time is 7 ms behind the display time.
FrameMoment shown(std::uint32_t i, const Twist& twist = kScrew) {
  const Duration now = kPeriod * i;
  return {.frame = {i + 1},
          .display_time = Time(now),
          .scene_time = Time(now - 7ms),
          .views = views_of(head_at(now, twist))};
}

double apart(const Rigid<Stage, Head>& a, const Rigid<Stage, Head>& b) {
  return angle_between_rad(a.rotation, b.rotation) + glm::length(a.translation - b.translation);
}

TEST(HeadOf, IsTheMiddleOfBothEyes) {
  const Rigid<Stage, Head> head = head_of(views_of(kStart));
  EXPECT_LT(angle_between_rad(head.rotation, kStart.rotation), 1e-12);
  EXPECT_LT(
      glm::length(head.translation - (kStart * Rigid<Head, Head>{{1, 0, 0, 0}, {0, 0, -0.01}}).translation),
      1e-12);
}

TEST(RequestPlan, HoldAsksForTheShownViewsAtTheirTime) {
  RequestPlan plan({.predictor = PredictorKind::Hold, .guard_band = GuardBandUse::Off});
  for (std::uint32_t i = 0; i < 50; ++i) {
    const FrameMoment now = shown(i);
    const auto request = plan.ask(now, kPeriod);
    ASSERT_TRUE(request.has_value());
    EXPECT_EQ(request->frame, now.frame);
    EXPECT_EQ(request->display_time, now.display_time);
    EXPECT_EQ(request->scene_time, now.scene_time);
    EXPECT_EQ(request->views, now.views) << "to the last bit";
    plan.learn(50ms);
    EXPECT_EQ(plan.lead(kPeriod), 0ms);
  }
}

TEST(RequestPlan, HeldViewsAreWidenedByWhatTheHeadTurnsInTheDelay) {
  RequestPlan plan({.predictor = PredictorKind::Hold, .guard_band = GuardBandUse::Measured});
  std::optional<FrameRequest> request;
  for (std::uint32_t i = 0; i < 60; ++i) {
    plan.learn(50ms);
    request = plan.ask(shown(i), kPeriod);
    if (i >= 5) plan.drawn_with(shown(i).views, shown(i - 5).views, 50ms);
  }
  const FrameMoment now = shown(59);
  EXPECT_EQ(request->display_time, now.display_time);
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    EXPECT_TRUE(shares_pixels(now.views[eye], request->views[eye])) << "the same pose, the same grid";
    // The view that is shown 50 ms later lies within the requested view.
    const Sides<double> out = outside_px(shown(64).views[eye], request->views[eye]);
    EXPECT_LE(out.left, 0.5);
    EXPECT_LE(out.right, 0.5);
  }
  EXPECT_GT(grid_offset_px(now.views[0], request->views[0]).x, 15) << "the head turns left";
}

/// Turning ignores the movement of the eye, so no margin helps against it.
TEST(RequestPlan, TurnedPicturesAreWidenedForTurnsOnly) {
  const Twist steps{{}, {2, 0, 0}}, turn{{0, 1.5, 0}, {}};
  const auto width = [](AnswerUse use, const Twist& twist) {
    RequestPlan plan({.predictor = PredictorKind::Hold});
    plan.use(use);
    std::optional<FrameRequest> request;
    for (std::uint32_t i = 0; i < 60; ++i) {
      request = plan.ask(shown(i, twist), kPeriod);
      if (i >= 5) plan.drawn_with(shown(i, twist).views, shown(i - 5, twist).views, 50ms);
    }
    return request->views[0].size.width;
  };
  EXPECT_GT(width(AnswerUse::Reprojected, steps), kShownSize.width);
  EXPECT_EQ(width(AnswerUse::Timewarped, steps), kShownSize.width);
  EXPECT_GT(width(AnswerUse::Timewarped, turn), kShownSize.width);
}

TEST(RequestPlan, AsksForThePoseAtTheTimeOfUse) {
  RequestPlan plan({.predictor = PredictorKind::Kalman, .guard_band = GuardBandUse::Off});
  for (std::uint32_t i = 0; i < 200; ++i) {
    const FrameMoment now = shown(i);
    if (i > 3) plan.learn(40ms);
    const auto request = plan.ask(now, kPeriod);
    ASSERT_TRUE(request.has_value());
    if (i < 120) continue;  // predictors learn the velocity first
    EXPECT_EQ(request->frame, now.frame);
    EXPECT_EQ(request->display_time, now.display_time + 40ms);
    EXPECT_EQ(request->scene_time, now.scene_time + 40ms);
    const StereoView right = views_of(head_at(kPeriod * i + 40ms));
    ASSERT_LT(apart(head_of(request->views), head_of(right)), 4e-3) << "frame " << i;
    EXPECT_GT(apart(head_of(now.views), head_of(right)), 0.05) << "a held pose would have this error";
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      EXPECT_EQ(request->views[eye].fov, now.views[eye].fov);
      EXPECT_EQ(request->views[eye].size, now.views[eye].size);
    }
    const auto between_eyes = [](const StereoView& v) {
      return inverse(v[0].stage_from_eye) * v[1].stage_from_eye;
    };
    const Rigid<Eye, Eye> a = between_eyes(request->views), b = between_eyes(now.views);
    EXPECT_LT(angle_between_rad(a.rotation, b.rotation) + glm::length(a.translation - b.translation), 1e-12)
        << "the eyes do not move within the head";
  }
}

TEST(RequestPlan, AHeadAtRestIsRequestedAsShown) {
  RequestPlan plan({.guard_band = GuardBandUse::Measured});
  for (std::uint32_t i = 0; i < 30; ++i) {
    plan.learn(30ms);
    const FrameMoment now = shown(i, Twist{});
    const auto request = plan.ask(now, kPeriod);
    EXPECT_EQ(request->display_time, now.display_time + 30ms);
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      EXPECT_EQ(request->views[eye].stage_from_eye, now.views[eye].stage_from_eye) << "frame " << i;
      EXPECT_EQ(request->views[eye].size, now.views[eye].size) << "no guard band is needed";
    }
  }
}

TEST(RequestPlan, AsksOnEveryNthFrame) {
  for (const std::uint32_t every : {1u, 2u, 3u, 8u}) {
    RequestPlan plan({.every = every});
    for (std::uint32_t i = 0; i < 40; ++i)
      EXPECT_EQ(plan.ask(shown(i), kPeriod).has_value(), i % every == 0) << "frame " << i << " of " << every;
  }
}

/// The numbers of the frames that ask, of the first `count`.
std::vector<std::uint32_t> asking(RequestPlan& plan, std::uint32_t count) {
  std::vector<std::uint32_t> frames;
  for (std::uint32_t i = 0; i < count; ++i)
    if (plan.ask(shown(i), kPeriod)) frames.push_back(i);
  return frames;
}

TEST(RequestPlanRate, IsOneInEachFrameUnlessNothingMovesAndMasksComeLate) {
  RequestPlan moving({}), prompt({}), late({});
  moving.learn(60ms);
  prompt.expect(SceneMotion::Still);
  prompt.learn(20ms);
  late.expect(SceneMotion::Still);
  late.learn(60ms);
  EXPECT_EQ(asking(moving, 7).size(), 7u);
  EXPECT_EQ(asking(prompt, 7).size(), 7u);
  EXPECT_EQ(asking(late, 7), (std::vector<std::uint32_t>{0, 3, 6})) << "28 ms are three periods of 10 ms";
  EXPECT_EQ(late.lead(kPeriod), 70ms) << "60 ms, and half of the time that a mask is used for";
}

TEST(RequestPlanRate, CountsDisplayPeriodsAndNotFrames) {
  RequestPlan plan({});
  plan.expect(SceneMotion::Still);
  plan.learn(60ms);
  for (const std::uint32_t i : {0u, 4u, 8u, 12u})
    EXPECT_TRUE(plan.ask(shown(i), kPeriod)) << "each frame comes 40 ms after the one before";
}

TEST(RequestPlanRate, ChangedLightsAreRequestedAtOnce) {
  RequestPlan plan({});
  plan.expect(SceneMotion::Still);
  plan.learn(60ms);
  EXPECT_TRUE(plan.ask(shown(0), kPeriod));
  FrameMoment changed = shown(1);
  ++changed.lights.revision.value;
  EXPECT_TRUE(plan.ask(changed, kPeriod));
}

TEST(RequestPlanRate, ADisplayTimeThatRunsBackwardsIsRequestedAtOnce) {
  RequestPlan plan({});
  plan.expect(SceneMotion::Still);
  plan.learn(60ms);
  EXPECT_TRUE(plan.ask(shown(100), kPeriod));
  EXPECT_FALSE(plan.ask(shown(101), kPeriod)) << "the masks of the frame before still hold";
  EXPECT_TRUE(plan.ask(shown(40), kPeriod));
  EXPECT_FALSE(plan.ask(shown(41), kPeriod));
  EXPECT_FALSE(plan.ask(shown(42), kPeriod));
  EXPECT_TRUE(plan.ask(shown(43), kPeriod)) << "three periods after the earlier time";
}

TEST(RequestPlanLead, IsTheMedianOfTheLatencies) {
  RequestPlan plan({});
  EXPECT_EQ(plan.lead(kPeriod), kPeriod) << "before anything is known";
  for (const Duration later : {Duration(20ms), Duration(500ms), Duration(30ms)}) plan.learn(later);
  EXPECT_EQ(plan.lead(kPeriod), 30ms);
  for (int i = 0; i < 32; ++i) plan.learn(60ms);
  EXPECT_EQ(plan.lead(kPeriod), 60ms) << "old latencies are forgotten";
}

TEST(RequestPlanLead, ForgetsWhatIsOlderThanThirtyTwoAnswers) {
  RequestPlan plan({});
  for (int i = 0; i < 200; ++i) plan.learn(20ms);
  for (int i = 0; i < 32; ++i) plan.learn(60ms);
  EXPECT_EQ(plan.lead(kPeriod), 60ms);
}

TEST(RequestPlanLead, IsRoundedUpToWholeFrames) {
  for (const auto& [latency, lead] : {std::pair{Duration(20ms), 20ms},
                                      {Duration(20ms + 5us), 20ms},
                                      {Duration(21ms), 30ms},
                                      {Duration(29ms), 30ms}}) {
    RequestPlan plan({});
    plan.learn(latency);
    EXPECT_EQ(plan.lead(kPeriod), lead) << latency.count();
  }
}

TEST(RequestPlanLead, AimsAtTheMiddleOfTheFramesThatAMaskIsUsedFor) {
  for (const std::uint32_t every : {1u, 2u, 3u, 8u}) {
    RequestPlan plan({.every = every});
    plan.learn(20ms);
    EXPECT_EQ(plan.lead(kPeriod), 20ms + kPeriod * (every - 1) / 2) << "one in " << every;
  }
}

TEST(RequestPlan, NeverRequestsInvalidViews) {
  RequestPlan plan(RequestSettings{});
  plan.learn(20ms);
  for (std::uint32_t i = 0; i < 20; ++i) {
    FrameMoment now = shown(i);
    for (View& view : now.views) view.size = {kMaxViewSide_px, 256};
    const std::optional<FrameRequest> request = plan.ask(now, kPeriod);
    ASSERT_TRUE(request);
    for (const View& view : request->views) ASSERT_TRUE(is_valid(view)) << "frame " << i;
  }
}

/// The views requested after a turn of the head to the left, with at most `pixels` per eye.
StereoView asked_within(std::uint32_t pixels) {
  RequestPlan plan(RequestSettings{});
  plan.learn(20ms);
  plan.limit(pixels);
  for (std::uint32_t i = 0; i < 20; ++i) {
    if (i >= 5) plan.drawn_with(shown(i).views, shown(i - 5).views, 5 * kPeriod);
    if (const auto request = plan.ask(shown(i), kPeriod); i == 19) return request->views;
  }
  return {};
}

TEST(RequestPlan, ShrinksTheGuardBandToWhatTheServerTraces) {
  const auto shown_pixels = static_cast<std::uint32_t>(kShownSize.pixels());
  const Extent unlimited = asked_within(~0u)[0].size;
  ASSERT_GE(unlimited.width, kShownSize.width + 3 * GuardBand::kStep_px);
  EXPECT_EQ(asked_within(static_cast<std::uint32_t>(unlimited.pixels()))[0].size, unlimited);
  EXPECT_EQ(asked_within(shown_pixels)[0].size, kShownSize) << "no room for a guard band";
  const auto one_step = shown_pixels + GuardBand::kStep_px * kShownSize.height;
  const Extent narrow = asked_within(one_step)[0].size;
  EXPECT_EQ(narrow, (Extent{kShownSize.width + GuardBand::kStep_px, kShownSize.height}))
      << "room for one step";
  const Extent less = asked_within(static_cast<std::uint32_t>(unlimited.pixels()) - 1)[0].size;
  EXPECT_LT(less.pixels(), unlimited.pixels());
  EXPECT_GE(less.pixels() + std::uint64_t{GuardBand::kStep_px} * unlimited.width, unlimited.pixels());
}

/// The width of the views of the 100th frame, if each frame is drawn with masks that were made for the views
/// `frames` frames earlier.
std::uint32_t width_when_masks_are_late(std::uint32_t frames) {
  RequestPlan plan({.predictor = PredictorKind::Kalman});
  for (std::uint32_t i = 0; i < 100; ++i) {
    plan.learn(40ms);
    const auto request = plan.ask(shown(i), kPeriod);
    if (i == 99) return request->views[0].size.width;
    if (i >= frames) plan.drawn_with(shown(i).views, shown(i - frames).views, kPeriod * (4 + frames));
  }
  return 0;
}

TEST(RequestPlan, WidensTheGuardBandWhenMasksComeLaterThanExpected) {
  const std::uint32_t in_time = width_when_masks_are_late(0), late = width_when_masks_are_late(4);
  EXPECT_GE(late, in_time + GuardBand::kStep_px);
}

TEST(RequestPlan, LearnsNothingOfMasksFromBeforeAPause) {
  RequestPlan plan({.predictor = PredictorKind::Hold});
  std::optional<FrameRequest> request;
  for (std::uint32_t i = 0; i < 60; ++i) {
    plan.drawn_with(shown(i + 300, Twist{{0, 0.3, 0}, {}}).views, shown(0).views, 3s);
    request = plan.ask(shown(i, Twist{}), kPeriod);
  }
  EXPECT_EQ(request->views[0].size, kShownSize);
}

TEST(RequestPlan, TracesWiderAfterUnpredictedTurns) {
  RequestPlan plan({.predictor = PredictorKind::Kalman});
  std::optional<FrameRequest> request;
  std::deque<StereoView> in_flight;
  for (std::uint32_t i = 0; i < 140; ++i) {
    plan.learn(40ms);
    FrameMoment now = shown(i, Twist{});
    // The head turns from side to side at 3 Hz, so the velocity has changed 40 ms later.
    now.views = views_of(kStart * motion_exp<Head>({{0, 0.15 * std::sin(19 * 0.01 * i), 0}, {}}));
    request = plan.ask(now, kPeriod);
    in_flight.push_back(request->views);
    if (in_flight.size() > 4) {
      plan.drawn_with(now.views, in_flight.front(), 40ms);
      in_flight.pop_front();
    }
    const Extent most = largest_traced(kShownSize);
    EXPECT_LE(request->views[0].size.width, most.width);
    EXPECT_LE(request->views[0].size.height, most.height);
    EXPECT_EQ(request->views[0].size, request->views[1].size);
  }
  EXPECT_GE(request->views[0].size.width, kShownSize.width + 2 * GuardBand::kStep_px);
}

TEST(RequestPlanShrink, AsksForTheSameWindowsWithFewerPixels) {
  for (const std::uint32_t eighths : {1u, 3u, 4u, 7u, 8u}) {
    RequestPlan plan({.predictor = PredictorKind::Hold, .guard_band = GuardBandUse::Off});
    plan.shrink({eighths});
    const FrameMoment now = shown(0);
    const std::optional<FrameRequest> request = plan.ask(now, kPeriod);
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      const View &view = request->views[eye], &full = now.views[eye];
      EXPECT_EQ(view.fov, full.fov);
      EXPECT_EQ(view.stage_from_eye, full.stage_from_eye);
      EXPECT_NEAR(view.size.width, full.size.width * eighths / 8.0, 0.5) << eighths;
      EXPECT_NEAR(view.size.height, full.size.height * eighths / 8.0, 0.5) << eighths;
    }
  }
}

TEST(RequestPlanShrink, LeavesSixteenPixelsOfASide) {
  RequestPlan plan({.predictor = PredictorKind::Hold, .guard_band = GuardBandUse::Off});
  plan.shrink(kLeastViewScale);
  FrameMoment now = shown(0);
  for (View& view : now.views) view.size = {100, 9};
  EXPECT_EQ(plan.ask(now, kPeriod)->views[0].size, (Extent{16, 9}));
}

TEST(RequestPlanShrink, KeepsTheGuardBandWhateverTheSize) {
  RequestPlan full(RequestSettings{.predictor = PredictorKind::Hold}), half(full);
  for (std::uint32_t i = 0; i < 60; ++i) {
    half.shrink({i % 20 < 10 ? 4u : 8u});  // distances that were observed at another size count in full
    for (RequestPlan* plan : {&full, &half}) {
      plan->learn(50ms);
      if (i >= 5) plan->drawn_with(shown(i).views, shown(i - 5).views, 50ms);
    }
    const std::optional<FrameRequest> wide = full.ask(shown(i), kPeriod),
                                      request = half.ask(shown(i), kPeriod);
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      const FovTangents a = tangents_of(wide->views[eye].fov), b = tangents_of(request->views[eye].fov);
      EXPECT_LE(b.left_tan, a.left_tan + 1e-9) << i;
      EXPECT_GE(b.right_tan, a.right_tan - 1e-9) << i;
      EXPECT_LE(request->views[eye].size.width, wide->views[eye].size.width);
      if (i % 20 >= 10) {
        EXPECT_EQ(request->views[eye], wide->views[eye]) << i;
      }
    }
  }
  EXPECT_GT(full.ask(shown(60), kPeriod)->views[0].size.width, kShownSize.width);
}

TEST(RequestPlanShrink, RoundsMarginsUpToWholeTiles) {
  RequestPlan full(RequestSettings{.predictor = PredictorKind::Hold}), less(full);
  less.shrink({7});
  for (std::uint32_t i = 0; i < 40; ++i) {
    for (RequestPlan* plan : {&full, &less}) {
      plan->learn(50ms);
      if (i >= 5) plan->drawn_with(shown(i).views, shown(i - 5).views, 50ms);
    }
    const auto wide = full.ask(shown(i), kPeriod)->views[0], scaled = less.ask(shown(i), kPeriod)->views[0];
    const FovTangents a = tangents_of(wide.fov), b = tangents_of(scaled.fov);
    EXPECT_EQ((scaled.size.width - kShownSize.width * 7 / 8) % GuardBand::kStep_px, 0u);
    ASSERT_LE(b.left_tan, a.left_tan + 1e-9) << "no narrower, frame " << i;
    ASSERT_GE(b.right_tan, a.right_tan - 1e-9) << "no narrower, frame " << i;
  }
}

TEST(RequestPlan, LearnsNothingOfAPause) {
  RequestPlan plan({});
  plan.learn(30ms);
  const Duration lead = plan.lead(10ms);
  for (int i = 0; i < 100; ++i) plan.learn(60s);
  EXPECT_EQ(plan.lead(10ms), lead);
}

TEST(RequestPlan, PausesWithTheScene) {
  RequestPlan plan({.guard_band = GuardBandUse::Off});
  plan.learn(30ms);
  const FrameMoment shown{FrameId{1}, Time(1s), Time(5s), {}, {}};
  EXPECT_GT(plan.ask(shown, 10ms)->scene_time, Time(5s));
  EXPECT_EQ(plan.ask(shown, 10ms, SceneClock::Paused)->scene_time, Time(5s));
  EXPECT_GT(plan.ask(shown, 10ms, SceneClock::Paused)->display_time, Time(1s));
}

}  // namespace
}  // namespace farshade
