#include "vr_client/preview/recordings.h"

#include <gtest/gtest.h>

#include "stereo/head/reader.h"
#include "stereo/image/codec.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

class TakesTest : public testing::Test {
 protected:
  TakesTest() { std::filesystem::create_directories(folder_); }
  ~TakesTest() override { std::filesystem::remove_all(folder_); }

  void show(Recordings& takes, int frames = 1) {
    for (int i = 0; i < frames; ++i) {
      request_.display_time += 10ms;
      takes.watch({.shown = request_,
                   .asked = nullptr,
                   .state = state_,
                   .masks = {},
                   .newest = nullptr,
                   .age = std::nullopt,
                   .times = times_,
                   .starts = starts_,
                   .steering = steering_,
                   .timing = {request_.display_time, 10ms}},
                  &eyes_, &eyes_);
    }
  }
  [[nodiscard]] bool is_there(const char* name) const { return std::filesystem::exists(folder_ / name); }

  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) /
      (std::string("takes_") + testing::UnitTest::GetInstance()->current_test_info()->name());
  SteadyClock clock_;
  PerEye<Image<Rgb8>> eyes_{Image<Rgb8>({4, 3}, Rgb8(10, 20, 30)), Image<Rgb8>({4, 3}, Rgb8(40, 50, 60))};
  FrameRequest request_ = [] {
    FrameRequest request;
    for (View& view : request.views) view = {{}, {-0.7, 0.8, 0.6, -0.5}, {4, 3}};
    request.views[1].stage_from_eye.translation.x = 0.063;
    return request;
  }();
  CaptureHeader header_ = [] {
    CaptureHeader header;
    header.limits = {.size = {4, 3}, .traced_size = {4, 3}};
    header.refresh_hz = 72;
    header.requests = 8;
    return header;
  }();
  SceneState state_;
  StageTimes times_;
  StageStarts starts_;
  FrameSettings steering_;
};

TEST_F(TakesTest, ScreenshotsAreNeverWrittenOver) {
  Recordings takes(folder_, clock_);
  takes.take_screenshot(eyes_, Image<Rgb8>({8, 8}));
  takes.take_screenshot(eyes_, {});
  EXPECT_TRUE(is_there("screenshot_0001_window.png"));
  EXPECT_FALSE(is_there("screenshot_0002_window.png")) << "minimised: there is none";
  const auto right = read_png(folder_ / "screenshot_0002_right.png");
  ASSERT_TRUE(right);
  EXPECT_EQ(right->pixels[0], Rgb8(40, 50, 60));
}

TEST_F(TakesTest, HeadIsWrittenWhenItsRecordingEnds) {
  Recordings takes(folder_, clock_);
  takes.toggle_head();
  EXPECT_TRUE(takes.records_head());
  show(takes, 5);
  takes.toggle_head();
  const auto trace = load_head_recording(folder_ / "head_0001.csv");
  ASSERT_TRUE(trace);
  EXPECT_EQ(trace->samples.size(), 5u);
  EXPECT_NEAR(trace->eye_distance_m, 0.063, 1e-12);
}

TEST_F(TakesTest, FramesAreBothEyesSideBySide) {
  Recordings takes(folder_, clock_);
  takes.toggle_frames();
  show(takes, 2);
  takes.toggle_frames();
  const auto frame = read_png(folder_ / "frames_0001" / "frame_00002.png");
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->size, (Extent{8, 3}));
  EXPECT_EQ(frame->at(3, 2), Rgb8(10, 20, 30));
  EXPECT_EQ(frame->at(4, 0), Rgb8(40, 50, 60));
}

TEST_F(TakesTest, AllThatIsBeingRecordedIsFinished) {
  Recordings takes(folder_, clock_);
  takes.toggle_head();
  takes.toggle_frames();
  (void)takes.listen();
  takes.begin_session({}, header_);
  EXPECT_TRUE(takes.records_session()) << takes.note();
  show(takes, 3);
  EXPECT_TRUE(takes.finish());
  EXPECT_TRUE(is_there("head_0001.csv"));
  EXPECT_TRUE(is_there("frames_0001/frame_00003.png"));
  EXPECT_TRUE(is_there("session_0001.farshade"));
  EXPECT_FALSE(takes.records_head() || takes.records_frames() || takes.records_session());
}

TEST_F(TakesTest, FailureIsSaidAndEndsTheTake) {
  Recordings takes(folder_ / "nowhere", clock_);
  (void)takes.listen();
  takes.begin_session({}, {});
  EXPECT_FALSE(takes.records_session());
  EXPECT_NE(takes.note().find("nowhere"), std::string::npos);
  takes.take_screenshot(eyes_, {});
  EXPECT_NE(takes.note().find("screenshot"), std::string::npos);
  EXPECT_FALSE(takes.finish());
}

TEST_F(TakesTest, LinkMayGoOnTellingAfterTheRecording) {
  Recordings takes(folder_, clock_);
  const LinkListener listener = takes.listen();
  takes.begin_session({}, header_);
  takes.end_session();
  listener.heard({}, Time{});
  listener.asked(request_);
}

}  // namespace
}  // namespace farshade
