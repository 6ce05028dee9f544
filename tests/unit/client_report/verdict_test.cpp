#include "vr_client/report/verdict.h"

#include <gtest/gtest.h>

#include "stereo/net/rate_control.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr RunTotals kAt100Hz{.period = 10ms};

/// Frames with these client times, each with an answer that took the server 4 ms.
FrameLog log_of(const std::vector<Duration>& client) {
  FrameLog log;
  for (const Duration time : client) {
    FrameRecord frame{.frame = {static_cast<std::uint32_t>(log.records().size() + 1)}};
    frame.times.frame = time;
    frame.requested = 1.0;
    frame.server = FrameReport{.shadow = 4ms, .bytes_per_second = 1'250'000};
    frame.traffic = LinkTraffic{.up = 250, .down = 5000};
    log.add(frame);
  }
  return log;
}

FrameRecord compared(double left_dB, double right_dB, double right_error) {
  FrameRecord frame{.frame = {1}};
  frame.errors = PerEye<EyeErrors>{};
  (*frame.errors)[0].psnr_db = left_dB;
  (*frame.errors)[1].psnr_db = right_dB;
  (*frame.errors)[1].mask_error = right_error;
  (*frame.errors)[0].flip = 0.01, (*frame.errors)[0].ssim = 0.9;
  (*frame.errors)[1].flip = 0.02, (*frame.errors)[1].ssim = 0.8;
  return frame;
}

std::string words(const FrameLog& log, RunTotals totals = kAt100Hz) {
  totals.frames = log.records().size();
  return in_words(verdict_of(log, totals), totals);
}

void expect_line(const std::string& text, const std::string& line) {
  EXPECT_NE(("\n" + text).find("\n" + line + "\n"), std::string::npos) << text;
}

TEST(Verdict, SaysThatTheWorkFits) {
  const std::string text = words(log_of({9ms, 9ms, 10ms}));
  expect_line(text, "time: client 9.0 ms of 10.0 ms a frame: fits; server 4.0 ms of 10.0 ms a frame: fits");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3) << text;
}

TEST(Verdict, SaysHowManyFramesAreTooSlow) {
  const FrameLog log = log_of({9ms, 9ms, 9ms, 11ms});
  EXPECT_NE(words(log).find("client 9.0 ms of 10.0 ms a frame: too slow in 25 % of frames;"),
            std::string::npos)
      << words(log);
  EXPECT_FALSE(verdict_of(log, kAt100Hz).fits());
}

TEST(Verdict, OneFrameOfAHundredMayBeSlow) {
  std::vector<Duration> times(99, 9ms);
  times.push_back(30ms);
  EXPECT_TRUE(verdict_of(log_of(times), kAt100Hz).fits());
  times[0] = 30ms;
  EXPECT_FALSE(verdict_of(log_of(times), kAt100Hz).fits());
}

TEST(Verdict, SaysHowFastSmallerPicturesWouldBe) {
  const FrameLog log = log_of({25ms, 25ms, 9ms});
  RunTotals totals = kAt100Hz;
  expect_line(
      words(log, totals),
      "time: client: 40 frames a second, the display has 100; server 4.0 ms of 10.0 ms a frame: fits");
  totals.eye_size = {512, 400};
  totals.cpu_draws = true;
  expect_line(words(log, totals),
              "time: without a GPU the CPU draws: 40 frames a second at 512x400, the display has 100; --size "
              "256x200 would have about 80 (an estimate); server 4.0 ms of 10.0 ms a frame: fits");
  EXPECT_NE(words(log_of({600ms}), totals)
                .find("1.7 frames a second at 512x400, the display has 100; --size 128x100 would have about "
                      "6.7 (an estimate)"),
            std::string::npos)
      << words(log_of({600ms}), totals);
  totals.eye_size = {100, 100};
  EXPECT_EQ(words(log, totals).find("--size"), std::string::npos) << "too small already";
}

TEST(Verdict, SaysHowOftenTheServerCanBeAsked) {
  FrameLog log;
  const FrameLog plain = log_of({1ms, 1ms});
  for (FrameRecord frame : plain.records()) {
    frame.server->shadow = 34ms;
    log.add(frame);
  }
  EXPECT_NE(
      words(log).find("; server: 29 answers a second, 100 were requested; --mask-every 4 requests as many"),
      std::string::npos)
      << words(log);
}

TEST(Verdict, TheServerHasTheTimeBetweenRequests) {
  FrameLog log;
  const FrameLog plain = log_of({1ms, 1ms, 1ms, 1ms});
  for (FrameRecord frame : plain.records()) {
    const bool asks = frame.frame.value % 2 == 0;
    if (!asks) frame.requested.reset();
    if (!asks) frame.server.reset();
    if (frame.server) frame.server->shadow = 15ms;
    log.add(frame);
  }
  EXPECT_NE(words(log).find("server 15.0 ms of 20.0 ms a request: fits"), std::string::npos) << words(log);
}

TEST(Verdict, SilentFramesDoNotCount) {
  FrameLog log = log_of({9ms, 9ms});
  FrameRecord silent = log.records().front();
  silent.silent = true;
  silent.times.frame = 900ms;
  silent.traffic = LinkTraffic{};
  log.add(silent);
  EXPECT_TRUE(verdict_of(log, kAt100Hz).fits());
  EXPECT_DOUBLE_EQ(verdict_of(log, kAt100Hz).bytes->down_bytes, 5000);
}

TEST(Verdict, StatesBytesAtTheRateOfTheDisplay) {
  expect_line(words(log_of({1ms, 1ms})),
              "bytes: 5.0 kB down and 0.2 kB up a frame: 4.0 and 0.2 Mbit/s at 100 Hz of 10 Mbit/s that the "
              "path was measured to carry down: fits");
}

TEST(Verdict, SaysThatThePathIsTooSlow) {
  FrameLog log;
  const FrameLog plain = log_of({1ms, 1ms});
  for (FrameRecord frame : plain.records()) {
    frame.server->bytes_per_second = 400'000;
    frame.server->view_scale = {6};
    log.add(frame);
  }
  EXPECT_NE(
      words(log).find(
          "of 3 Mbit/s that the path was measured to carry down: does not fit, the server asks for 75 % of "
          "the width\n"),
      std::string::npos)
      << words(log);
  EXPECT_FALSE(verdict_of(log, kAt100Hz).fits());
}

TEST(Verdict, JudgesWhatIsSentUpToo) {
  FrameLog log;
  const FrameLog plain = log_of({1ms, 1ms});
  for (FrameRecord frame : plain.records()) {
    frame.traffic->up = 50'000;
    log.add(frame);
  }
  EXPECT_NE(
      words(log).find("4.0 and 40.0 Mbit/s at 100 Hz of 10 Mbit/s that the path was measured to carry down: "
                      "does not fit, if it carries no more up"),
      std::string::npos)
      << words(log);
  EXPECT_FALSE(verdict_of(log, kAt100Hz).fits());
}

/// The server begins with an estimate that it has not measured.
TEST(Verdict, TheFirstEstimateOfThePathIsNoMeasurement) {
  FrameLog log;
  const FrameLog plain = log_of({1ms, 1ms, 1ms});
  for (FrameRecord frame : plain.records()) {
    frame.server->bytes_per_second = static_cast<std::uint32_t>(RateControl::kStart);
    log.add(frame);
  }
  EXPECT_FALSE(verdict_of(log, kAt100Hz).bytes->path);
  EXPECT_NE(words(log).find("; the rate of the path was not measured: the run sent too little; --path-rate "
                            "states it\n"),
            std::string::npos)
      << words(log);
  FrameRecord later = log.records().front();
  later.server->bytes_per_second = 2'000'000;
  log.add(later);
  EXPECT_DOUBLE_EQ(verdict_of(log, kAt100Hz).bytes->path.value().down_mbit_s, 16);
}

TEST(Verdict, JudgesThePathThatTheUserStates) {
  const FrameLog log = log_of({1ms, 1ms});  // 4 Mbit/s down and 0.2 up, over a measured path of 10
  RunTotals totals = kAt100Hz;
  totals.stated_path = PathRate{.down_mbit_s = 4.5, .up_mbit_s = 0.25};
  EXPECT_NE(words(log, totals).find("at 100 Hz of 4.5 and 0.25 Mbit/s that --path-rate states: fits\n"),
            std::string::npos)
      << words(log, totals);
  totals.stated_path = PathRate{.down_mbit_s = 4.5, .up_mbit_s = 0.1};
  EXPECT_NE(words(log, totals).find("of 4.5 and 0.1 Mbit/s that --path-rate states: does not fit\n"),
            std::string::npos)
      << words(log, totals);
  EXPECT_FALSE(verdict_of(log, totals).fits());
  totals.stated_path = PathRate{.down_mbit_s = 3.5};
  EXPECT_NE(words(log, totals).find("of 3.5 Mbit/s that --path-rate states: does not fit\n"),
            std::string::npos)
      << words(log, totals);
}

TEST(Verdict, CountsMissedDisplayTimes) {
  RunTotals totals = kAt100Hz;
  totals.missed = 37;
  const FrameLog log = log_of({9ms, 9ms, 9ms});
  EXPECT_NE(words(log, totals).find("; 37 of 40 display times were missed\n"), std::string::npos)
      << words(log, totals);
  totals.frames = 3;
  EXPECT_FALSE(verdict_of(log, totals).fits());
}

TEST(Verdict, StatesThePictureOfTheWorseEye) {
  FrameLog log;
  for (int i = 0; i < 3; ++i) log.add(compared(40, 35, 0.02));
  expect_line(words(log),
              "picture: PSNR 35.0 dB against a full trace, 35.0 dB in the worst 1 % of frames; FLIP 0.020, "
              "SSIM 0.800; mask error 2.00 %, 2.00 % in the worst 1 % (right eye, the worse one)");
}

TEST(Verdict, PicturesFromInsideOfGeometryAreNotValid) {
  FrameLog log;
  log.add(compared(kEqualPictures_dB, kEqualPictures_dB, 0));
  RunTotals totals = kAt100Hz;
  for (const double share : {0.0, 0.5, 0.51, 1.0}) {
    totals.inside_share = share;
    EXPECT_EQ(verdict_of(log, totals).is_valid, share <= 0.5);
    EXPECT_EQ(words(log, totals).find("picture: INVALID: the head is inside geometry in ") == 0, share > 0.5)
        << words(log, totals);
  }
  EXPECT_FALSE(verdict_of(log, totals).fits());
}

TEST(Verdict, SaysThatPicturesAreEqual) {
  FrameLog log;
  log.add(compared(kEqualPictures_dB, kEqualPictures_dB, 0));
  expect_line(words(log), "picture: equal to a full trace");
  log.add(compared(kEqualPictures_dB, 60, 0.001));
  EXPECT_EQ(words(log).find("equal to"), std::string::npos) << words(log);
}

TEST(Verdict, SaysWhatWasNotMeasured) {
  FrameLog log;
  log.add({.frame = {1}});
  expect_line(words(log),
              "picture: not measured: no frame was compared with a full trace; --reference-every 8 "
              "compares every 8th");
  expect_line(words(log), "bytes: no network was used");
  RunTotals totals = kAt100Hz;
  totals.reference_every = 8;
  expect_line(
      words(log, totals),
      "picture: not measured: no frame was compared with a full trace, which happens every 8 frames: use "
      "--frames 16 or more");
  totals.start_up_frames = 1;
  expect_line(
      words(log, totals),
      "picture: not measured: no frame has shown an answer of the server; 1 are few, use --frames 60");
  EXPECT_EQ(words(log).find("server"), std::string::npos) << words(log);
  expect_line(words(FrameLog()), "time: no frame was shown");
}

}  // namespace
}  // namespace farshade
