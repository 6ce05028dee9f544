#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>

#include "tests/unit/client_record/capture_samples.h"
#include "tests/unit/scratch_folder.h"
#include "vr_client/record/capture_writer.h"

namespace farshade {
namespace {

using namespace record_samples;
using namespace std::chrono_literals;

/// A frame as a session shows it, with the views of `input(number)`.
void watch(CaptureWriter& recorder, std::uint32_t number) {
  const CapturedFrameInput made = input(number);
  const FrameRequest shown{FrameId{number}, made.timing.display_time, {}, made.views};
  const SceneState state;
  const StageTimes times;
  const StageStarts starts;
  recorder.watch({.shown = shown,
                  .asked = nullptr,
                  .state = state,
                  .masks = {},
                  .newest = nullptr,
                  .age = {},
                  .times = times,
                  .starts = starts,
                  .steering = made.steering,
                  .timing = made.timing},
                 {Image<Rgb8>(kEye), Image<Rgb8>(kEye, {1, 2, 3})});
}

TEST(CaptureWriter, WritesFramesWithWhatWasHeardAndAskedSinceTheLast) {
  const ScratchFolder folder;
  const std::filesystem::path path = folder.path() / "a.session";
  ManualClock clock;
  CaptureWriter recorder(clock);
  const LinkListener tell = recorder.listener();
  tell.heard(wire_samples::encoded(wire_samples::welcome()), Time(1ms));
  ASSERT_TRUE(recorder.open(path, header()).has_value());
  clock.advance_to(Time(3ms));
  tell.asked(asked(1).request);
  tell.heard(wire_samples::encoded(ServerMessage(Probe{5})), Time(4ms));
  watch(recorder, 1);
  watch(recorder, 2);
  EXPECT_EQ(recorder.frames(), 2u);
  EXPECT_EQ(recorder.bytes(), std::filesystem::file_size(path)) << "all is in the file though it is open";

  CaptureReader reader = std::move(*CaptureReader::open(path));
  const CapturedFrame one = reader.next().value().value(), two = reader.next().value().value();
  ASSERT_EQ(one.before.size(), 1u);
  EXPECT_EQ(one.before[0].arrived, Time(1ms));
  ASSERT_TRUE(one.asked.has_value());
  EXPECT_EQ(one.asked->sent, Time(3ms));
  ASSERT_EQ(one.after.size(), 1u);
  EXPECT_EQ(one.input.views, input(1).views);
  EXPECT_EQ(one.shown[0], hash_of(Image<Rgb8>(kEye)));
  EXPECT_NE(one.shown[1], one.shown[0]);
  EXPECT_TRUE(two.before.empty() && two.after.empty() && !two.asked);
}

TEST(CaptureWriter, SaysWhyAFileCannotBeBegun) {
  const ScratchFolder folder;
  ManualClock clock;
  CaptureWriter recorder(clock);
  const Expected<void> opened = recorder.open(folder.path() / "none" / "a.session", header());
  ASSERT_FALSE(opened.has_value());
  EXPECT_EQ(opened.error().fault, Fault::Missing);
  EXPECT_NE(opened.error().what.find("a.session"), std::string::npos);
}

TEST(CaptureWriter, SaysThatADiskIsFull) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no disk that is always full";
  const ScratchFolder folder;
  std::filesystem::create_symlink("/dev/full", folder.path() / "a.session");
  ManualClock clock;
  CaptureWriter recorder(clock);
  const Expected<void> opened = recorder.open(folder.path() / "a.session", header());
  ASSERT_FALSE(opened.has_value());
  EXPECT_NE(opened.error().what.find("No space left"), std::string::npos) << opened.error().what;
}

/// No file of this process grows beyond `bytes`.
class DiskOf {
 public:
  explicit DiskOf(rlim_t bytes) : signal_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  DiskOf(const DiskOf&) = delete;
  DiskOf& operator=(const DiskOf&) = delete;
  ~DiskOf() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, signal_);
  }

 private:
  void (*signal_)(int);
  rlimit before_{};
};

TEST(CaptureWriter, OnADiskThatFillsEndsTheRecordingAndNothingElse) {
  const ScratchFolder folder;
  const std::filesystem::path path = folder.path() / "a.session";
  ManualClock clock;
  CaptureWriter recorder(clock);
  ASSERT_TRUE(recorder.open(path, header()).has_value());
  {
    const DiskOf small(1000);
    for (std::uint32_t number = 1; number <= 10; ++number) watch(recorder, number);
  }
  ASSERT_TRUE(recorder.failed().has_value());
  const std::string last = std::to_string(recorder.frames() + 1);
  EXPECT_TRUE(recorder.failed()->what.ends_with("; its recording ends before frame " + last))
      << recorder.failed()->what;
  EXPECT_NE(recorder.failed()->what.find(path.string()), std::string::npos);
  EXPECT_GT(recorder.frames(), 0u);
  EXPECT_EQ(count_frames(path).value(), recorder.frames()) << "what was written can be replayed";
}

}  // namespace
}  // namespace farshade
