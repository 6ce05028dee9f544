/// HeadRecording: recorded head poses, in metres and nanoseconds, with eye distance and fov of the headset.
#pragma once

#include <string>
#include <vector>

#include "stereo/base/clock.h"
#include "stereo/frame/view.h"

namespace farshade {

/// Of a headset that does not state it: a mean of adults.
inline constexpr double kDefaultEyeDistance_m = 0.063;

struct HeadSample {
  Time time;
  Rigid<Recorded, Head> recorded_from_head;
};

/// At least two samples; times strictly increasing; rotations unit.
struct HeadRecording {
  std::vector<HeadSample> samples;
  double eye_distance_m = kDefaultEyeDistance_m;
  PerEye<EyeFov> fov;
  std::size_t rows_left_out = 0;  ///< rows of the file with repeated or backward stamps
  std::size_t bad_rows = 0;       ///< rows of the file that are no pose: cut off, lost tracking, no numbers
  std::string read_as{};  ///< a sentence about what the reader found and assumed; empty if no file was read
  std::string doubt{};  ///< why the recording may be read wrongly, or what is missing; empty: nothing is odd

  [[nodiscard]] Time start() const { return samples.front().time; }
  [[nodiscard]] Time end() const { return samples.back().time; }
};

/// The head at `time`, interpolated between samples. Constant before the first and after the last sample.
[[nodiscard]] Rigid<Recorded, Head> head_at(const HeadRecording& recording, Time time);

/// The transform that places the first head position and heading of the recording at those of `reference`.
/// The direction of gravity stays.
[[nodiscard]] Rigid<Stage, Recorded> place(const HeadRecording& recording,
                                           const Rigid<Stage, Eye>& reference);

/// The pose of an eye in the head: half the eye distance to its side, looking straight ahead.
[[nodiscard]] Rigid<Head, Eye> head_from_eye(Side side, double eye_distance_m);

}  // namespace farshade
