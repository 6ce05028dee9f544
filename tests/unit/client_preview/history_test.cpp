#include "vr_client/preview/history.h"

#include <gtest/gtest.h>

namespace farshade {
namespace {

using namespace std::chrono_literals;

/// A frame whose parts a test sets before it adds the frame.
struct Shown {
  FrameRequest request;
  SceneState state;
  StageTimes times;
  StageStarts starts;
  FrameSettings settings;
  std::optional<FrameRequest> sent;

  Shown() {
    for (View& view : request.views) view.size = {100, 100};
  }
  [[nodiscard]] FrameView view() const {
    return {.shown = request,
            .request = sent ? &*sent : nullptr,
            .state = state,
            .masks = {},
            .newest = nullptr,
            .age = std::nullopt,
            .times = times,
            .starts = starts,
            .settings = settings,
            .timing = {}};
  }
};

TEST(History, TheStagesOfAFrameAddUpToItsTime) {
  Shown shown;
  shown.times = {{.gbuffer = 10ms, .depth = 3ms, .shade = 5ms, .total = 20ms}, 1ms, 2ms, {}};
  shown.starts.end = Time(100ms);
  History history;
  history.add(shown.view(), {}, nullptr, Time(107ms));
  ASSERT_EQ(history.bars().size(), 1u);
  const FrameBar& bar = history.bars().front();
  EXPECT_EQ(bar.other, 2ms);
  EXPECT_EQ(bar.watch, 7ms);
  EXPECT_EQ(bar.request + bar.collect + bar.gbuffer + bar.depth + bar.shade + bar.other + bar.watch, 30ms);
}

TEST(History, KeepsTheFramesOfTheGraphAndTwoSecondsOfFigures) {
  Shown shown;
  History history;
  for (int frame = 0; frame < 300; ++frame) {
    shown.times.frame = frame < 150 ? 40ms : 10ms;
    history.add(shown.view(), {}, nullptr, Time(20ms * frame));
  }
  EXPECT_EQ(history.bars().size(), kGraphFrames);
  const Figures figures = history.figures();
  EXPECT_NEAR(figures.frames_per_s, 50, 1e-9);
  EXPECT_EQ(figures.frame_ms, 10) << "the first half lies more than two seconds back";
}

TEST(History, LeavesUnknownFiguresEmpty) {
  Shown shown;
  History history;
  EXPECT_EQ(history.figures().frame_ms, std::nullopt);
  history.add(shown.view(), {}, nullptr, Time(1ms));
  const Figures figures = history.figures();
  EXPECT_EQ(figures.staleness_ms, std::nullopt);
  EXPECT_EQ(figures.round_trip_ms, std::nullopt);
  EXPECT_EQ(figures.loss_percent, std::nullopt);
  EXPECT_EQ(figures.errors, std::nullopt);
}

TEST(History, StatesTheGuardBandOfTheNewestRequest) {
  Shown shown;
  shown.sent = shown.request;
  for (View& view : shown.sent->views) view.size = {120, 110};
  History history;
  history.add(shown.view(), {}, nullptr, Time(1ms));
  EXPECT_NEAR(*history.figures().guard_band_percent, 32, 1e-9);
  EXPECT_EQ(history.figures().requested, (Extent{120, 110}));
}

TEST(History, DropsErrorsWhenMeasuringStops) {
  Shown shown;
  History history;
  history.add(shown.view(), PerEye<EyeErrors>{}, nullptr, Time(1ms));
  EXPECT_TRUE(history.figures().errors);
  history.add(shown.view(), {}, nullptr, Time(2ms));
  EXPECT_FALSE(history.figures().errors);
}

}  // namespace
}  // namespace farshade
