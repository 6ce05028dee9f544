/// How fast a recorded head turns, for tests on whole recordings.
#pragma once

#include <numbers>
#include <vector>

#include "stereo/head/head_recording.h"
#include "stereo/math/rotation.h"

namespace farshade {

/// The speeds between neighbouring samples, up to `end`, in degrees per second.
inline std::vector<double> turn_speeds_deg_s(const HeadRecording& recording, Time end) {
  std::vector<double> speeds;
  for (std::size_t i = 1; i < recording.samples.size() && recording.samples[i].time <= end; ++i) {
    const HeadSample &a = recording.samples[i - 1], &b = recording.samples[i];
    const double angle = angle_between_rad(a.recorded_from_head.rotation, b.recorded_from_head.rotation);
    speeds.push_back(angle * 180.0 / std::numbers::pi / seconds_of(b.time - a.time));
  }
  return speeds;
}

}  // namespace farshade
