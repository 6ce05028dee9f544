/// SampleList: the one gate through which recorded samples of every format pass.
#pragma once

#include "stereo/head/head_recording.h"
#include "stereo/head/rows.h"

namespace farshade {

class SampleList {
 public:
  /// Positions are divided by `units_a_metre`.
  explicit SampleList(double units_a_metre) : units_a_metre_(units_a_metre) {}

  /// Renormalises `rotation`. Refuses what load_head_recording refuses of one row.
  [[nodiscard]] Expected<void> add(rows::Place place, std::int64_t stamp_ns, const glm::dvec3& position,
                                   const glm::dquat& rotation);

  /// The trace of the longest part of the samples whose stamps grow, in the order of the file, with the
  /// headset's properties. Refuses too few samples and impossible headsets.
  [[nodiscard]] Expected<HeadRecording> finish(std::string_view file, double eye_distance_m,
                                               const PerEye<EyeFov>& fov) &&;

 private:
  double units_a_metre_;
  HeadRecording trace_;
};

}  // namespace farshade
