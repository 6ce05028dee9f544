#include "vr_client/preview/recordings.h"

#include <gtest/gtest.h>

#include "stereo/head/reader.h"
#include "tests/support/image_reader.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

class RecordingsTest : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  void show(Recordings& recordings, int frames = 1) {
    for (int i = 0; i < frames; ++i) {
      request_.display_time += 10ms;
      recordings.watch({.shown = request_,
                        .request = nullptr,
                        .state = state_,
                        .masks = {},
                        .newest = nullptr,
                        .age = std::nullopt,
                        .times = times_,
                        .starts = starts_,
                        .settings = settings_,
                        .timing = {request_.display_time, 10ms}},
                       &eyes_, &eyes_);
    }
  }
  [[nodiscard]] bool is_there(const char* name) const { return std::filesystem::exists(folder_ / name); }

  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) /
      (std::string("recordings_") + testing::UnitTest::GetInstance()->current_test_info()->name());
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
  FrameSettings settings_;
};

TEST_F(RecordingsTest, NeverOverwritesScreenshots) {
  Recordings recordings(folder_, clock_);
  recordings.take_screenshot(eyes_, Image<Rgb8>({8, 8}));
  recordings.take_screenshot(eyes_, {});
  EXPECT_TRUE(is_there("screenshot_0001_window.png"));
  EXPECT_FALSE(is_there("screenshot_0002_window.png")) << "the window is minimised";
  const auto right = read_png(folder_ / "screenshot_0002_right.png");
  ASSERT_TRUE(right);
  EXPECT_EQ(right->pixels[0], Rgb8(40, 50, 60));
}

TEST_F(RecordingsTest, WritesTheHeadWhenItsRecordingEnds) {
  Recordings recordings(folder_, clock_);
  recordings.toggle_head();
  EXPECT_TRUE(recordings.records_head());
  show(recordings, 5);
  recordings.toggle_head();
  const auto trace = load_head_recording(folder_ / "head_0001.csv");
  ASSERT_TRUE(trace);
  EXPECT_EQ(trace->samples.size(), 5u);
  EXPECT_NEAR(trace->eye_distance_m, 0.063, 1e-12);
}

TEST_F(RecordingsTest, WritesBothEyesOfAFrameSideBySide) {
  Recordings recordings(folder_, clock_);
  recordings.toggle_frames();
  show(recordings, 2);
  recordings.toggle_frames();
  const auto frame = read_png(folder_ / "frames_0001" / "frame_00002.png");
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->size, (Extent{8, 3}));
  EXPECT_EQ(frame->at(3, 2), Rgb8(10, 20, 30));
  EXPECT_EQ(frame->at(4, 0), Rgb8(40, 50, 60));
}

TEST_F(RecordingsTest, FinishesAllActiveRecordings) {
  Recordings recordings(folder_, clock_);
  recordings.toggle_head();
  recordings.toggle_frames();
  (void)recordings.listen();
  recordings.begin_capture({}, header_);
  EXPECT_TRUE(recordings.writes_capture()) << recordings.note();
  show(recordings, 3);
  EXPECT_TRUE(recordings.finish());
  EXPECT_TRUE(is_there("head_0001.csv"));
  EXPECT_TRUE(is_there("frames_0001/frame_00003.png"));
  EXPECT_TRUE(is_there("capture_0001.farshade"));
  EXPECT_FALSE(recordings.records_head() || recordings.records_frames() || recordings.writes_capture());
}

TEST_F(RecordingsTest, ReportsAFailureAndEndsTheRecording) {
  Recordings recordings(folder_ / "nowhere", clock_);
  (void)recordings.listen();
  recordings.begin_capture({}, {});
  EXPECT_FALSE(recordings.writes_capture());
  EXPECT_NE(recordings.note().find("nowhere"), std::string::npos);
  recordings.take_screenshot(eyes_, {});
  EXPECT_NE(recordings.note().find("screenshot"), std::string::npos);
  EXPECT_FALSE(recordings.finish());
}

TEST_F(RecordingsTest, IgnoresMessagesAfterTheCapture) {
  Recordings recordings(folder_, clock_);
  const LinkListener listener = recordings.listen();
  recordings.begin_capture({}, header_);
  recordings.end_capture();
  listener.received({}, Time{});
  listener.sent(request_);
}

}  // namespace
}  // namespace farshade
