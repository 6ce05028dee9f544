/// Headset: the geometry of the two eyes of a headset.
#pragma once

#include "stereo/frame/view.h"

namespace farshade {

struct Headset {
  double eye_distance_m = 0.063;
  PerEye<EyeFov> fov;
  Extent eye_size;  ///< pixels of each eye
  friend bool operator==(const Headset&, const Headset&) = default;
};

/// The views of both eyes. Each eye is half the eye distance beside the head's centre and looks ahead.
[[nodiscard]] StereoView views_of(const Rigid<Stage, Head>& stage_from_head, const Headset& headset);

/// Limits of both angles of field_of_view.
inline constexpr double kNarrowestView_rad = 0.017453292519943295;  // 1 degree
inline constexpr double kWidestView_rad = 2.9670597283903604;       // 170 degrees

/// The symmetric field of view with this full vertical angle and square pixels. `aspect` is width / height,
/// above 0. The angle is clamped so that it is at least 1 degree and neither height nor width exceeds 170
/// degrees.
[[nodiscard]] EyeFov field_of_view(double vertical_rad, double aspect);

}  // namespace farshade
