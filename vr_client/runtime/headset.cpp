#include "vr_client/runtime/headset.h"

#include <algorithm>
#include <cmath>

#include "stereo/base/check.h"
#include "stereo/head/head_recording.h"

namespace farshade {

StereoView views_of(const Rigid<Stage, Head>& stage_from_head, const Headset& headset) {
  StereoView views;
  for (const Side side : kSides)
    views[index_of(side)] = {stage_from_head * head_from_eye(side, headset.eye_distance_m),
                             headset.fov[index_of(side)], headset.eye_size};
  return views;
}

EyeFov field_of_view(double vertical_rad, double aspect) {
  check(std::isfinite(vertical_rad) && std::isfinite(aspect) && aspect > 0, "a field of view has a shape");
  const double asked_rad = std::clamp(vertical_rad, kNarrowestView_rad, kWidestView_rad);
  const double widest = std::tan(0.5 * kWidestView_rad);
  const double height = std::min(std::tan(0.5 * asked_rad), widest / std::max(aspect, 1.0));
  const double half_up = std::atan(height);
  const double half_right = std::atan(height * aspect);
  return {-half_right, half_right, half_up, -half_up};
}

}  // namespace farshade
