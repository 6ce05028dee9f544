/// SampleList: collects and checks the samples of a head recording. All file formats use it.
#pragma once

#include "stereo/head/head_recording.h"
#include "stereo/head/rows.h"

namespace farshade {

class SampleList {
 public:
  /// Divides positions by `units_a_metre`.
  explicit SampleList(double units_a_metre) : units_a_metre_(units_a_metre) {}

  /// Normalises `rotation`. Refuses a row as load_head_recording does.
  [[nodiscard]] Expected<void> add(rows::Place place, std::int64_t stamp_ns, const glm::dvec3& position,
                                   const glm::dquat& rotation);

  /// The recording: the longest subsequence of the samples with increasing stamps, and the properties of the
  /// headset. Refuses too few samples and invalid headsets.
  [[nodiscard]] Expected<HeadRecording> finish(std::string_view file, double eye_distance_m,
                                               const PerEye<EyeFov>& fov) &&;

 private:
  double units_a_metre_;
  HeadRecording recording_;
};

}  // namespace farshade
