#include <gtest/gtest.h>

#include "tests/unit/client_record/capture_samples.h"
#include "vr_client/record/replay.h"

namespace farshade {
namespace {

using namespace record_samples;
using namespace std::chrono_literals;

/// What the session at hand asks in this frame if it does as the one that was recorded.
FrameRequest as_recorded(const CapturedFrame& frame) {
  return frame.asked->request;
}

TEST(CaptureLink, HearsInTheFrameAndOnTheSideOfTheRequestThatItWasHeardOn) {
  CaptureLink link(header());
  CapturedFrame one = frame(1);
  one.before.push_back(heard(Welcome{wire_samples::counting_hash(), 3, 4242}));
  link.begin(one);
  EXPECT_EQ(link.inbox().most_pixels(), 4242u);
  link.request(as_recorded(one), Time(14ms));
  ASSERT_NE(link.inbox().find(FrameId{1}), nullptr);
  EXPECT_EQ(link.inbox().find(FrameId{1})->origin.sent, one.asked->sent);
  EXPECT_FALSE(link.inbox().find(FrameId{1})->report_arrived.has_value());
  link.wait_for(FrameId{1}, 0s);
  EXPECT_EQ(link.inbox().find(FrameId{1})->report_arrived, Time(1s));
  EXPECT_EQ(link.end(), std::nullopt);
}

TEST(CaptureLink, AsksNothingBeforeItIsWelcome) {
  CaptureLink link(header());
  CapturedFrame one = frame(1), two = frame(2);
  for (CapturedFrame* each : {&one, &two}) each->asked.reset(), each->after.clear(), each->before.clear();
  two.before = {heard(wire_samples::welcome())};
  for (const CapturedFrame* each : {&one, &two}) {
    link.begin(*each);
    link.request({.frame = {1}, .display_time = {}, .scene_time = {}, .views = {}}, {});
    link.wait_for(FrameId{1}, 0s);
    EXPECT_EQ(link.end(), std::nullopt);
  }
  EXPECT_EQ(link.inbox().find(FrameId{1}), nullptr);
}

TEST(CaptureLink, NamesWhatIsAskedOtherwise) {
  struct Case {
    std::function<void(FrameRequest&)> change;
    const char* what;
  };
  for (const Case& each : {
           Case{[](FrameRequest& r) { r.frame.value = 9; }, "asks as frame 9, not as frame 1"},
           Case{[](FrameRequest& r) { r.display_time += 2ms; }, "asks for a display time 2"},
           Case{[](FrameRequest& r) { r.scene_time += 1ms; }, "asks for a scene time 1"},
           Case{[](FrameRequest& r) { r.views[1].size.width = 7; }, "asks for another size of the right eye"},
           Case{[](FrameRequest& r) { r.views[0].fov.up_rad = 0.5; }, "asks for another fov of the left eye"},
           Case{[](FrameRequest& r) { r.views[0].stage_from_eye.translation.x += 1e-15; },
                "asks for another pose of the left eye"},
           Case{[](FrameRequest& r) { change(r.lights, 0, false, {}); }, "asks with other changes of lights"},
       }) {
    CaptureLink link(header());
    const CapturedFrame one = frame(1);
    FrameRequest asked = as_recorded(one);
    each.change(asked);
    link.begin(one);
    link.request(asked, Time(14ms));
    link.wait_for(asked.frame, 0s);
    const std::optional<std::string> what = link.end();
    ASSERT_TRUE(what.has_value()) << each.what;
    EXPECT_TRUE(what->starts_with(each.what)) << *what;
  }
}

TEST(CaptureLink, TellsRequestsThatAreMissingOrTooMany) {
  CaptureLink link(header());
  const CapturedFrame one = frame(1);
  link.begin(one);
  EXPECT_EQ(link.end(), "asks for nothing, where a request was recorded");
  CapturedFrame two = frame(2);
  two.asked.reset();
  link.begin(two);
  link.request(as_recorded(frame(2)), Time(28ms));
  EXPECT_EQ(link.end(), "asks, where nothing was asked");
}

TEST(Replay, GivesTimesViewsAndSteeringOfEachFrame) {
  std::vector<CapturedFrame> frames{frame(1), frame(2)};
  frames[1].input.steering.scene = SceneClock::Stands;
  frames[1].input.views[0].stage_from_eye.translation.y = 3;
  Replay replay(std::move(*reader_of(file_of(header(), frames))), ShadingPass::Report::On);
  EXPECT_NE(replay.link(), nullptr);
  for (const CapturedFrame& each : frames) {
    const std::optional<FrameTiming> timing = replay.wait_frame();
    ASSERT_TRUE(timing.has_value());
    EXPECT_EQ(timing->display_time, each.input.timing.display_time);
    EXPECT_EQ(timing->period, each.input.timing.period);
    EXPECT_EQ(replay.locate_views(timing->display_time), each.input.views);
    EXPECT_EQ(replay.steering().scene, each.input.steering.scene);
    EXPECT_EQ(replay.steering().report, ShadingPass::Report::On);
  }
  EXPECT_FALSE(replay.wait_frame().has_value());
  EXPECT_TRUE(replay.verdict().has_value());
}

TEST(Replay, EndsWhereTheFileIsWrongAndSaysSo) {
  Bytes file = file_of(header(), std::vector{frame(1)});
  file.push_back(std::byte{77});
  file.resize(file.size() + 4);
  Replay replay(std::move(*reader_of(file)), ShadingPass::Report::Off);
  EXPECT_TRUE(replay.wait_frame().has_value());
  EXPECT_FALSE(replay.wait_frame().has_value());
  ASSERT_FALSE(replay.verdict().has_value());
  EXPECT_NE(replay.verdict().error().what.find("no kind of record"), std::string::npos);
}

TEST(ReplayVerdict, IsOneSentence) {
  EXPECT_EQ(to_string(ReplayVerdict{.frames = 312, .first = {}}),
            "312 frames, all requests and pictures as recorded");
  EXPECT_EQ(to_string(ReplayVerdict{.frames = 9, .first = ReplayDifference{{4}, "shows snow"}}),
            "frame 4 of 9 frames differs: it shows snow");
}

}  // namespace
}  // namespace farshade
