/// The fixed list of pose deltas that reprojection is judged on: how the eyes that a mask was traced for
/// stand to the eyes that are shown.
#pragma once

#include <span>
#include <string_view>

#include "stereo/frame/view.h"

namespace farshade {

/// The traced head is the shown one after a turn and a step in its own axes; both heads have the same eyes
/// but for `zoom`.
struct PoseCase {
  const char* name;
  double yaw_degrees = 0;                     ///< to the left
  double roll_degrees = 0;                    ///< to the left shoulder
  double step_m = 0;                          ///< to the right
  double zoom = 1;                            ///< the traced views' window on z = -1 over the shown views'
  EyeFov left_fov{-0.60, 0.50, 0.52, -0.56};  ///< shown; the right eye's is its mirror image
  double eye_distance_m = 0.063;
};

[[nodiscard]] std::span<const PoseCase> pose_cases();
/// The case of that name; throws where there is none.
[[nodiscard]] const PoseCase& pose_case(std::string_view name);

struct PoseViews {
  StereoView shown, traced;  ///< of one size
};

/// `head` is shown. Every eye has `side_px` x `side_px` pixels.
[[nodiscard]] PoseViews views_of(const PoseCase& pose, const Rigid<Stage, Head>& head, std::uint32_t side_px);

}  // namespace farshade
