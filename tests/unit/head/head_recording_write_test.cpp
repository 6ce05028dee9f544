#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "stereo/base/files.h"
#include "stereo/head/reader.h"
#include "stereo/head/writer.h"
#include "stereo/math/rotation.h"

namespace farshade {
namespace {

HeadRecording random_recording(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  HeadRecording recording;
  recording.eye_distance_m = 0.06 + 0.01 * any(random);
  recording.fov = {EyeFov{-0.9, 0.1 + 0.5 / 3, 0.7, -0.8}, EyeFov{-0.6, 0.9, 1.0 / 3, -0.8}};
  std::int64_t ns = -3'000'000'007;
  for (int i = 0; i < 200; ++i, ns += 1 + static_cast<std::int64_t>(random() % 100'000'000))
    recording.samples.push_back({time_from_ns(ns),
                                 {rotation_exp({3 * any(random), 3 * any(random), 3 * any(random)}),
                                  {any(random), 1e-7 * any(random), 1e6 * any(random)}}});
  return recording;
}

void expect_same(const HeadRecording& a, const HeadRecording& b) {
  EXPECT_EQ(a.eye_distance_m, b.eye_distance_m);
  EXPECT_EQ(a.fov, b.fov);
  ASSERT_EQ(a.samples.size(), b.samples.size());
  for (std::size_t i = 0; i < a.samples.size(); ++i) {
    EXPECT_EQ(a.samples[i].time, b.samples[i].time);
    EXPECT_EQ(a.samples[i].recorded_from_head, b.samples[i].recorded_from_head) << "sample " << i;
  }
}

TEST(HeadRecordingRoundTrip, KeepsEveryBitInBothFormats) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const HeadRecording recording = random_recording(seed);
    const auto euroc = parse_head_recording(euroc_text(recording), "t.csv");
    const auto tum = parse_head_recording(tum_text(recording), "t.txt");
    ASSERT_TRUE(euroc) << euroc.error().what;
    ASSERT_TRUE(tum) << tum.error().what;
    expect_same(*euroc, recording);
    expect_same(*tum, recording);
  }
}

TEST(EurocText, IsWhatTheFormatSays) {
  HeadRecording recording;
  recording.fov = kDefaultFov;
  recording.samples = {{time_from_ns(5), {glm::dquat(0.8, 0.6, 0, 0), {1, 2, -3.5}}}};
  EXPECT_EQ(euroc_text(recording),
            "# axes: +x right, +y up, -z ahead, right-handed\n"
            "# units: m, ns\n"
            "# clock: monotonic\n"
            "# space: head in stage\n"
            "# eye distance [m]: 0.063\n"
            "# fov left eye [rad] left right up down: -0.942 0.698 0.733 -0.942\n"
            "# fov right eye [rad] left right up down: -0.698 0.942 0.733 -0.942\n"
            "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []\n"
            "5,1,2,-3.5,0.8,0.6,0,0\n");
}

TEST(TumText, PutsTheScalarLast) {
  HeadRecording recording;
  recording.samples = {{time_from_ns(-1'500'000'000), {glm::dquat(0.8, 0.6, 0, 0), {1, 2, 3}}}};
  const std::string text = tum_text(recording);
  EXPECT_EQ(text.substr(text.find("qw\n") + 3), "-1.500000000 1 2 3 0.6 0 0 0.8\n");
}

TEST(HeadRecordingWrite, WritesFilesAndLeavesNothingWhereItMayNot) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "farshade_trace_write";
  std::filesystem::create_directories(folder);
  const HeadRecording recording = random_recording(9);
  ASSERT_TRUE(write_file_atomically(folder / "a.csv", euroc_text(recording)));
  ASSERT_TRUE(write_file_atomically(folder / "a.txt", tum_text(recording)));
  expect_same(load_head_recording(folder / "a.csv").value(), recording);
  expect_same(load_head_recording(folder / "a.txt").value(), recording);
  EXPECT_FALSE(write_file_atomically(folder / "missing" / "a.csv", euroc_text(recording)));
  EXPECT_FALSE(std::filesystem::exists(folder / "missing"));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace farshade
