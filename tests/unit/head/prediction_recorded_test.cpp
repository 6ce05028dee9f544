/// The default predictor is the best one on real heads (EyeNavGS), if the recordings lie beside the
/// repository. docs/prediction.md has the whole table.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "stereo/base/quantile.h"
#include "stereo/head/prediction.h"
#include "stereo/head/reader.h"

namespace farshade {
namespace {

/// The error in radians that 95 % of the predictions made at 72 Hz stay below.
double turn_error_p95(const HeadRecording& recording, PredictorKind kind, Duration lead) {
  Predictor predictor(kind);
  std::vector<double> errors;
  for (int frame = 0;; ++frame) {
    const Time now = recording.start() + Duration(std::llround(frame * 1e9 / 72));
    if (now + lead > recording.end()) return quantile(errors, 0.95);
    predictor.observe(now, Rigid<Stage, Recorded>{} * head_at(recording, now));
    errors.push_back(
        angle_between_rad(predictor.predict(now + lead).rotation, head_at(recording, now + lead).rotation));
  }
}

class PredictorOnRecordedHead : public testing::TestWithParam<const char*> {};

TEST_P(PredictorOnRecordedHead, DefaultHasTheShortestTail) {
  const auto recording = load_head_recording(std::string(FARSHADE_TRACES "/") + GetParam());
  ASSERT_TRUE(recording) << recording.error().what;
  for (const int lead_ms : {50, 100}) {
    std::map<PredictorKind, double> p95;
    for (const PredictorKind kind : kPredictorKinds)
      p95[kind] = turn_error_p95(*recording, kind, std::chrono::milliseconds(lead_ms));
    for (const PredictorKind kind : kPredictorKinds) {
      EXPECT_GE(p95[kind], p95[kDefaultPredictor]) << to_string(kind) << ' ' << lead_ms << " ms";
      if (kind != PredictorKind::Hold) {
        EXPECT_LT(p95[kind], 0.6 * p95[PredictorKind::Hold]) << to_string(kind) << ' ' << lead_ms << " ms";
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(EyeNavGs, PredictorOnRecordedHead,
                         testing::Values("eyenavgs_truck_user101.csv", "eyenavgs_truck_user102.csv",
                                         "eyenavgs_truck_user104.csv", "eyenavgs_room_user103.csv"));

}  // namespace
}  // namespace farshade
