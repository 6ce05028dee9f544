/// The fixed list of pose deltas for the tests of reprojection. A delta leads from the shown eyes to the eyes
/// that a mask was traced for.
#pragma once

#include <span>
#include <string_view>

#include "stereo/frame/view.h"

namespace farshade {

/// The traced head is the shown head after a turn and a step in its own axes. Both have the same eyes, except
/// for `zoom`.
struct PoseCase {
  const char* name;
  double yaw_degrees = 0;   ///< to the left
  double roll_degrees = 0;  ///< to the left shoulder
  double step_m = 0;        ///< to the right
  double zoom = 1;          ///< size of the traced views' windows relative to the shown views'
  EyeFov left_fov{-0.60, 0.50, 0.52, -0.56};  ///< shown; the right eye's is its mirror image
  double eye_distance_m = 0.063;
};

[[nodiscard]] std::span<const PoseCase> pose_cases();
/// The case of that name. Throws if there is none.
[[nodiscard]] const PoseCase& pose_case(std::string_view name);

struct PoseViews {
  StereoView shown, traced;  ///< of one size
};

/// `head` is the shown head. Every eye has `side_px` x `side_px` pixels.
[[nodiscard]] PoseViews views_of(const PoseCase& pose, const Rigid<Stage, Head>& head, std::uint32_t side_px);

}  // namespace farshade
