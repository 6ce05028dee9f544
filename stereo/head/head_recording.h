/// HeadRecording: a recorded head, in metres and nanoseconds, and what its headset's eyes were.
#pragma once

#include <vector>

#include "stereo/base/clock.h"
#include "stereo/frame/view.h"

namespace farshade {

struct HeadSample {
  Time time;
  Rigid<Recorded, Head> recorded_from_head;
};

/// At least two samples; times strictly increasing; rotations unit.
struct HeadRecording {
  std::vector<HeadSample> samples;
  double eye_distance_m = 0.063;
  PerEye<EyeFov> fov;
  std::size_t rows_left_out = 0;  ///< rows of the file whose stamps repeat another or run backward

  [[nodiscard]] Time start() const { return samples.front().time; }
  [[nodiscard]] Time end() const { return samples.back().time; }
};

/// The head at `time`: lerp and slerp between neighbours, held outside the recording.
[[nodiscard]] Rigid<Recorded, Head> head_at(const HeadRecording& trace, Time time);

/// Carries the trace's first head position and heading over to `reference`'s position and heading. Gravity
/// stays.
[[nodiscard]] Rigid<Stage, Recorded> place(const HeadRecording& trace, const Rigid<Stage, Eye>& reference);

/// An eye in the head: half the eye distance to its side, looking straight ahead.
[[nodiscard]] Rigid<Head, Eye> head_from_eye(Side side, double eye_distance_m);

}  // namespace farshade
