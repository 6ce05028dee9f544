/// Headset: what a head wears, and where that puts its two views.
#pragma once

#include "stereo/frame/view.h"

namespace farshade {

struct Headset {
  double eye_distance_m = 0.063;
  PerEye<EyeFov> fov;
  Extent eye_size;  ///< pixels of each eye
  friend bool operator==(const Headset&, const Headset&) = default;
};

/// Each eye half the eye distance to its side, looking where the head looks.
[[nodiscard]] StereoView views_of(const Rigid<Stage, Head>& stage_from_head, const Headset& headset);

/// What both angles of `field_of_view` keep within, radians.
inline constexpr double kNarrowestView_rad = 0.017453292519943295;  // 1 degree
inline constexpr double kWidestView_rad = 2.9670597283903604;       // 170 degrees

/// A symmetric eye of this full vertical angle whose pixels are square; `aspect` is width / height, > 0.
/// An angle below 1 degree counts as 1 degree; one with which the larger of height and width would exceed
/// 170 degrees counts as the largest with which it does not.
[[nodiscard]] EyeFov field_of_view(double vertical_rad, double aspect);

}  // namespace farshade
