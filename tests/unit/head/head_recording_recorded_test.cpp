/// Real heads (EyeNavGS), if the recordings lie beside the repository: their speeds are those that their
/// README states.
#include <gtest/gtest.h>

#include "stereo/base/quantile.h"
#include "stereo/head/reader.h"
#include "tests/unit/head/head_speed.h"

namespace farshade {
namespace {

struct Recording {
  const char* file;
  double seconds, median, p99, largest;  ///< degrees/s
  const char* tilt;                      ///< of the scene, in degrees
};
std::ostream& operator<<(std::ostream& out, const Recording& recording) {
  return out << recording.file;
}

class RecordedHead : public testing::TestWithParam<Recording> {};

TEST_P(RecordedHead, TurnsAsFastAsItsReadmeSays) {
  const auto& [file, seconds, median, p99, largest, tilt] = GetParam();
  const auto recording = load_head_recording(std::string(FARSHADE_TRACES "/") + file);
  ASSERT_TRUE(recording) << recording.error().what;
  const std::vector<double> speeds = turn_speeds_deg_s(*recording, recording->end());
  EXPECT_NEAR(seconds_of(recording->end() - recording->start()), seconds, 1.0);
  EXPECT_NEAR(quantile(speeds, 0.5), median, 0.1 * median);
  EXPECT_NEAR(quantile(speeds, 0.99), p99, 0.1 * p99);
  EXPECT_NEAR(quantile(speeds, 1.0), largest, 0.1 * largest);
  EXPECT_GT(recording->eye_distance_m, 0.058);
  EXPECT_LT(recording->eye_distance_m, 0.068);
  EXPECT_EQ(recording->fov, kDefaultFov);
  EXPECT_EQ(recording->rows_left_out, 0u);
  EXPECT_NE(recording->doubt.find(std::string("levelled by ") + tilt + " degrees"), std::string::npos)
      << recording->doubt;
}

INSTANTIATE_TEST_SUITE_P(EyeNavGs, RecordedHead,
                         testing::Values(Recording{"eyenavgs_truck_user101.csv", 76, 24, 110, 259, "10.6"},
                                         Recording{"eyenavgs_truck_user102.csv", 79, 35, 159, 246, "11.2"},
                                         Recording{"eyenavgs_truck_user104.csv", 66, 39, 161, 321, "12.2"},
                                         Recording{"eyenavgs_room_user103.csv", 64, 30, 118, 189, "24.3"}));

}  // namespace
}  // namespace farshade
