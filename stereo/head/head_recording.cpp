#include "stereo/head/head_recording.h"

#include <algorithm>

#include "stereo/base/check.h"
#include "stereo/math/rotation.h"

namespace farshade {

Rigid<Recorded, Head> head_at(const HeadRecording& recording, Time time) {
  check(recording.samples.size() >= 2, "a head recording has at least two samples");
  const auto after = std::upper_bound(recording.samples.begin(), recording.samples.end(), time,
                                      [](Time t, const HeadSample& sample) { return t < sample.time; });
  if (after == recording.samples.begin()) return recording.samples.front().recorded_from_head;
  if (after == recording.samples.end()) return recording.samples.back().recorded_from_head;
  const HeadSample& before = *std::prev(after);
  const double t = seconds_of(time - before.time) / seconds_of(after->time - before.time);
  return interpolate(before.recorded_from_head, after->recorded_from_head, t);
}

Rigid<Stage, Recorded> place(const HeadRecording& recording, const Rigid<Stage, Eye>& reference) {
  check(!recording.samples.empty(), "a recording to place has a first sample");
  const Rigid<Recorded, Head>& first = recording.samples.front().recorded_from_head;
  const double turn_rad = heading_rad(reference.rotation) - heading_rad(first.rotation);
  const glm::dquat turn = rotation_exp({0.0, turn_rad, 0.0});
  return {turn, reference.translation - turn * first.translation};
}

Rigid<Head, Eye> head_from_eye(Side side, double eye_distance_m) {
  const double half = 0.5 * eye_distance_m;
  return {glm::dquat(1.0, 0.0, 0.0, 0.0), {side == Side::Left ? -half : half, 0.0, 0.0}};
}

}  // namespace farshade
