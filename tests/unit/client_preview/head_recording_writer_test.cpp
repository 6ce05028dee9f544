#include <gtest/gtest.h>

#include "stereo/head/reader.h"
#include "stereo/math/rotation.h"
#include "tests/unit/scratch_folder.h"
#include "vr_client/preview/recordings.h"
#include "vr_client/runtime/headset.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

const Headset kHeadset{0.061, {EyeFov{-0.9, 0.7, 0.7, -0.8}, EyeFov{-0.7, 0.9, 0.7, -0.8}}, {64, 48}};

Rigid<Stage, Head> head_of_frame(int frame) {
  const double t = 0.1 * frame;
  return {rotation_exp({0.3 * t, -0.7 * t, 0.05 * t}), {1 + t, 1.6 - 0.1 * t, -t * t}};
}

TEST(HeadRecordingWriter, WritesAFileThatLoadsAsTheSamePoses) {
  const ScratchFolder folder;
  const std::filesystem::path path = folder.path() / "head.csv";
  HeadRecordingWriter writer;
  for (int frame = 0; frame < 50; ++frame)
    writer.add(Time(5s + 13'888'889ns * frame), views_of(head_of_frame(frame), kHeadset));
  ASSERT_TRUE(writer.write(path).has_value());
  const HeadRecording loaded = load_head_recording(path).value();
  ASSERT_EQ(loaded.samples.size(), 50u);
  EXPECT_NEAR(loaded.eye_distance_m, kHeadset.eye_distance_m, 1e-12);
  EXPECT_EQ(loaded.fov, kHeadset.fov);
  for (int frame = 0; frame < 50; ++frame) {
    const Rigid<Recorded, Head> got = head_at(loaded, Time(5s + 13'888'889ns * frame));
    const Rigid<Stage, Head> expected = head_of_frame(frame);
    EXPECT_LT(glm::length(got.translation - expected.translation), 1e-12) << frame;
    EXPECT_GT(std::abs(glm::dot(got.rotation, expected.rotation)), 1 - 1e-12) << frame;
  }
}

TEST(HeadRecordingWriter, SkipsTimesThatDoNotIncrease) {
  const ScratchFolder folder;
  HeadRecordingWriter writer;
  for (const int ms : {10, 20, 20, 15, 30, 40})
    writer.add(Time(std::chrono::milliseconds(ms)), views_of(head_of_frame(ms), kHeadset));
  ASSERT_TRUE(writer.write(folder.path() / "head.csv").has_value());
  const HeadRecording loaded = load_head_recording(folder.path() / "head.csv").value();
  ASSERT_EQ(loaded.samples.size(), 4u);
  EXPECT_EQ(loaded.rows_left_out, 0u);
  EXPECT_EQ(loaded.end(), Time(40ms));
}

TEST(HeadRecordingWriter, RefusesARecordingThatIsTooShort) {
  const ScratchFolder folder;
  HeadRecordingWriter writer;
  writer.add(Time(1s), views_of(head_of_frame(0), kHeadset));
  writer.add(Time(2s), views_of(head_of_frame(1), kHeadset));
  EXPECT_EQ(writer.write(folder.path() / "head.csv").error().fault, Fault::OutOfRange);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "head.csv"));
}

}  // namespace
}  // namespace farshade
