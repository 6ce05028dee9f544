#include <gtest/gtest.h>

#include "tests/unit/client_record/capture_samples.h"
#include "vr_client/record/replay.h"

namespace farshade {
namespace {

using namespace record_samples;
using namespace std::chrono_literals;

/// The request that equals the captured one.
FrameRequest as_captured(const CapturedFrame& frame) {
  return frame.request->request;
}

TEST(CaptureLink, ReplaysMessagesBeforeAndAfterTheRequest) {
  CaptureLink link(header());
  CapturedFrame one = frame(1);
  one.before.push_back(received(Welcome{wire_samples::counting_hash(), 3, 4242}));
  link.begin(one);
  EXPECT_EQ(link.receiver().most_pixels(), 4242u);
  link.request(as_captured(one), Time(14ms));
  ASSERT_NE(link.receiver().find(FrameId{1}), nullptr);
  EXPECT_EQ(link.receiver().find(FrameId{1})->origin.sent, one.request->sent);
  EXPECT_FALSE(link.receiver().find(FrameId{1})->report_arrived.has_value());
  link.wait_for(FrameId{1}, 0s);
  EXPECT_EQ(link.receiver().find(FrameId{1})->report_arrived, Time(1s));
  EXPECT_EQ(link.end(), std::nullopt);
}

TEST(CaptureLink, SendsNoRequestBeforeTheWelcome) {
  CaptureLink link(header());
  CapturedFrame one = frame(1), two = frame(2);
  for (CapturedFrame* each : {&one, &two}) each->request.reset(), each->after.clear(), each->before.clear();
  two.before = {received(wire_samples::welcome())};
  for (const CapturedFrame* each : {&one, &two}) {
    link.begin(*each);
    link.request({{.frame = {1}, .display_time = {}, .scene_time = {}, .views = {}}}, {});
    link.wait_for(FrameId{1}, 0s);
    EXPECT_EQ(link.end(), std::nullopt);
  }
  EXPECT_EQ(link.receiver().find(FrameId{1}), nullptr);
}

TEST(CaptureLink, NamesTheDifferenceOfARequest) {
  struct Case {
    std::function<void(FrameRequest&)> change;
    const char* what;
  };
  for (const Case& each : {
           Case{[](FrameRequest& r) { r.frame.value = 9; }, "requests frame 9 instead of frame 1"},
           Case{[](FrameRequest& r) { r.display_time += 2ms; }, "requests a display time 2"},
           Case{[](FrameRequest& r) { r.scene_time += 1ms; }, "requests a scene time 1"},
           Case{[](FrameRequest& r) { r.views[1].size.width = 7; }, "requests another size of the right eye"},
           Case{[](FrameRequest& r) { r.views[0].fov.up_rad = 0.5; }, "requests another fov of the left eye"},
           Case{[](FrameRequest& r) { r.views[0].stage_from_eye.translation.x += 1e-15; },
                "requests another pose of the left eye"},
           Case{[](FrameRequest& r) { change(r.lights, 0, false, {}); }, "requests other light changes"},
       }) {
    CaptureLink link(header());
    const CapturedFrame one = frame(1);
    FrameRequest request = as_captured(one);
    each.change(request);
    link.begin(one);
    link.request(request, Time(14ms));
    link.wait_for(request.frame, 0s);
    const std::optional<std::string> what = link.end();
    ASSERT_TRUE(what.has_value()) << each.what;
    EXPECT_TRUE(what->starts_with(each.what)) << *what;
  }
}

TEST(CaptureLink, ReportsMissingAndSurplusRequests) {
  CaptureLink link(header());
  const CapturedFrame one = frame(1);
  link.begin(one);
  EXPECT_EQ(link.end(), "sends no request, though one was captured");
  CapturedFrame two = frame(2);
  two.request.reset();
  link.begin(two);
  link.request(as_captured(frame(2)), Time(28ms));
  EXPECT_EQ(link.end(), "sends a request that was not captured");
}

TEST(Replay, GivesTimesViewsAndSettingsOfEachFrame) {
  std::vector<CapturedFrame> frames{frame(1), frame(2)};
  frames[1].input.settings.scene = SceneClock::Paused;
  frames[1].input.views[0].stage_from_eye.translation.y = 3;
  Replay replay(std::move(*reader_of(file_of(header(), frames))), PixelReport::On);
  EXPECT_NE(replay.link(), nullptr);
  for (const CapturedFrame& each : frames) {
    const std::optional<FrameTiming> timing = replay.wait_frame();
    ASSERT_TRUE(timing.has_value());
    EXPECT_EQ(timing->display_time, each.input.timing.display_time);
    EXPECT_EQ(timing->period, each.input.timing.period);
    EXPECT_EQ(replay.locate_views(timing->display_time), each.input.views);
    EXPECT_EQ(replay.settings().scene, each.input.settings.scene);
    EXPECT_EQ(replay.settings().report, PixelReport::On);
  }
  EXPECT_FALSE(replay.wait_frame().has_value());
  EXPECT_TRUE(replay.verdict().has_value());
}

TEST(Replay, NamesTheEyeWhosePictureDiffers) {
  const Image<Rgb8> black(kEye), white(kEye, Rgb8(255));
  struct Case {
    Image<Rgb8> left, right;
    const char* what;
  };
  for (const Case& each :
       {Case{black, black, nullptr}, Case{white, black, "shows another picture to the left eye"},
        Case{black, white, "shows another picture to the right eye"},
        Case{white, white, "shows other pictures to both eyes"}}) {
    CaptureHeader alone = header();
    alone.origin = MaskOrigin::Nobody;
    const CapturedFrame captured{.input = input(1),
                                 .before = {},
                                 .request = {},
                                 .after = {},
                                 .pictures = {hash_of(black), hash_of(black)}};
    Replay replay(std::move(*reader_of(file_of(alone, std::vector{captured}))), PixelReport::Off);
    ASSERT_TRUE(replay.wait_frame().has_value());
    const FrameMoment shown = sent_request(1).request;
    const SceneState state;
    const StageTimes times;
    const StageStarts starts;
    replay.watch({.shown = shown,
                  .request = nullptr,
                  .state = state,
                  .masks = {},
                  .newest = nullptr,
                  .age = {},
                  .times = times,
                  .starts = starts,
                  .settings = captured.input.settings,
                  .timing = captured.input.timing},
                 {each.left, each.right});
    const ReplayVerdict verdict = replay.verdict().value();
    EXPECT_EQ(verdict.frames, 1u);
    ASSERT_EQ(verdict.first.has_value(), each.what != nullptr);
    if (each.what != nullptr) {
      EXPECT_EQ(verdict.first->what, each.what);
    }
  }
}

TEST(Replay, EndsAtAFaultOfTheFile) {
  Bytes file = file_of(header(), std::vector{frame(1)});
  file.push_back(std::byte{77});
  file.resize(file.size() + 4);
  Replay replay(std::move(*reader_of(file)), PixelReport::Off);
  EXPECT_TRUE(replay.wait_frame().has_value());
  EXPECT_FALSE(replay.wait_frame().has_value());
  ASSERT_FALSE(replay.verdict().has_value());
  EXPECT_NE(replay.verdict().error().what.find("bytes after the end record"), std::string::npos);
}

TEST(ReplayVerdict, IsOneSentence) {
  EXPECT_EQ(to_string(ReplayVerdict{.frames = 2, .first = {}, .cut_off = "a is cut off"}),
            "2 frames, all requests and pictures as captured; a is cut off");
  EXPECT_EQ(to_string(ReplayVerdict{.frames = 312, .first = {}}),
            "312 frames, all requests and pictures as captured");
  EXPECT_EQ(to_string(ReplayVerdict{.frames = 9, .first = ReplayDifference{{4}, "shows snow"}}),
            "frame 4 of 9 frames differs: it shows snow");
}

}  // namespace
}  // namespace farshade
