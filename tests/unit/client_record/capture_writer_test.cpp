#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>

#include "tests/support/manual_clock.h"
#include "tests/unit/client_record/capture_samples.h"
#include "tests/unit/scratch_folder.h"
#include "vr_client/record/capture_writer.h"

namespace farshade {
namespace {

using namespace record_samples;
using namespace std::chrono_literals;

/// Passes a shown frame to the writer, with the views of `input(number)`.
void watch(CaptureWriter& writer, std::uint32_t number) {
  const CapturedFrameInput made = input(number);
  const FrameMoment shown{FrameId{number}, made.timing.display_time, {}, made.views};
  const SceneState state;
  const StageTimes times;
  const StageStarts starts;
  writer.watch({.shown = shown,
                .request = nullptr,
                .state = state,
                .masks = {},
                .newest = nullptr,
                .age = {},
                .times = times,
                .starts = starts,
                .settings = made.settings,
                .timing = made.timing},
               {Image<Rgb8>(kEye), Image<Rgb8>(kEye, {1, 2, 3})});
}

TEST(CaptureWriter, WritesEachFrameWithItsMessagesAndRequest) {
  const ScratchFolder folder;
  const std::filesystem::path path = folder.path() / "a.capture";
  ManualClock clock;
  CaptureWriter writer(clock);
  const LinkListener tell = writer.listener();
  tell.received(wire_samples::encoded(wire_samples::welcome()), Time(1ms));
  ASSERT_TRUE(writer.open(path, header()).has_value());
  clock.advance_to(Time(3ms));
  tell.sent(sent_request(1).request);
  tell.received(wire_samples::encoded(ServerMessage(Probe{5})), Time(4ms));
  watch(writer, 1);
  watch(writer, 2);
  EXPECT_EQ(writer.frames(), 2u);
  EXPECT_EQ(writer.bytes(), std::filesystem::file_size(path))
      << "everything is in the file while it is still open";

  CaptureReader reader = std::move(*CaptureReader::open(path));
  const CapturedFrame one = reader.next().value().value(), two = reader.next().value().value();
  ASSERT_EQ(one.before.size(), 1u);
  EXPECT_EQ(one.before[0].arrived, Time(1ms));
  ASSERT_TRUE(one.request.has_value());
  EXPECT_EQ(one.request->sent, Time(3ms));
  ASSERT_EQ(one.after.size(), 1u);
  EXPECT_EQ(one.input.views, input(1).views);
  EXPECT_EQ(one.pictures[0], hash_of(Image<Rgb8>(kEye)));
  EXPECT_NE(one.pictures[1], one.pictures[0]);
  EXPECT_TRUE(two.before.empty() && two.after.empty() && !two.request);
}

TEST(CaptureWriter, ReportsAFileThatCannotBeCreated) {
  const ScratchFolder folder;
  ManualClock clock;
  CaptureWriter writer(clock);
  const Expected<void> opened = writer.open(folder.path() / "none" / "a.capture", header());
  ASSERT_FALSE(opened.has_value());
  EXPECT_EQ(opened.error().fault, Fault::Missing);
  EXPECT_NE(opened.error().what.find("a.capture"), std::string::npos);
}

/// Limits every file of this process to `bytes`.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : signal_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, signal_);
  }

 private:
  void (*signal_)(int);
  rlimit before_{};
};

TEST(CaptureWriter, ReportsAFullDisk) {
  const ScratchFolder folder;
  ManualClock clock;
  CaptureWriter writer(clock);
  const FileSizeLimit none(1);
  const Expected<void> opened = writer.open(folder.path() / "a.capture", header());
  ASSERT_FALSE(opened.has_value());
  EXPECT_NE(opened.error().what.find("File too large"), std::string::npos) << opened.error().what;
}

TEST(CaptureWriter, KeepsAFileThatExists) {
  const ScratchFolder folder;
  const std::filesystem::path path = folder.path() / "a.capture";
  ManualClock clock;
  {
    CaptureWriter writer(clock);
    ASSERT_TRUE(writer.open(path, header()).has_value());
    watch(writer, 1);
  }
  EXPECT_EQ(count_frames(path).value(), 1u);
  const auto size = std::filesystem::file_size(path);
  CaptureWriter second(clock);
  for (const Expected<void>& refused : {CaptureWriter::may_create(path), second.open(path, header())}) {
    ASSERT_FALSE(refused.has_value());
    EXPECT_EQ(refused.error().fault, Fault::Unavailable);
    EXPECT_NE(refused.error().what.find(path.string() + " exists: name another file"), std::string::npos);
  }
  EXPECT_EQ(std::filesystem::file_size(path), size);
  EXPECT_TRUE(CaptureWriter::may_create({}).has_value());
}

TEST(CaptureWriter, EndsTheFileWhenItFinishesAndNotBefore) {
  const ScratchFolder folder;
  ManualClock clock;
  const auto lacks = [](const std::filesystem::path& path) {
    CaptureReader reader = std::move(*CaptureReader::open(path));
    while (reader.next().value()) {
    }
    return reader.cut_off().has_value();
  };
  CaptureWriter writer(clock);
  ASSERT_TRUE(writer.open(folder.path() / "a", header()).has_value());
  watch(writer, 1);
  EXPECT_TRUE(lacks(folder.path() / "a"));
  EXPECT_TRUE(writer.finish().has_value());
  EXPECT_FALSE(lacks(folder.path() / "a"));
  EXPECT_EQ(writer.bytes(), std::filesystem::file_size(folder.path() / "a"));
}

TEST(CaptureWriter, EndsTheCaptureWhenTheDiskFills) {
  const ScratchFolder folder;
  const std::filesystem::path path = folder.path() / "a.capture";
  ManualClock clock;
  CaptureWriter writer(clock);
  ASSERT_TRUE(writer.open(path, header()).has_value());
  {
    const FileSizeLimit small(1000);
    for (std::uint32_t number = 1; number <= 10; ++number) watch(writer, number);
  }
  ASSERT_TRUE(writer.failed().has_value());
  const std::string last = std::to_string(writer.frames() + 1);
  EXPECT_TRUE(writer.failed()->what.ends_with("; the capture ends before frame " + last))
      << writer.failed()->what;
  EXPECT_NE(writer.failed()->what.find(path.string()), std::string::npos);
  EXPECT_GT(writer.frames(), 0u);
  EXPECT_EQ(count_frames(path).value(), writer.frames()) << "the written frames can be replayed";
}

}  // namespace
}  // namespace farshade
