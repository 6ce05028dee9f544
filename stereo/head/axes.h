/// Axes: which way the axes of a recording's positions and of its heads point, and how they become those of
/// the stage (+x right, +y up, -z ahead). Named conventions:
///
/// | name | x, y, z of the world | x, y, z of the head | source |
/// |---|---|---|---|
/// | openxr | right, up, back | the same | OpenXR 1.1, section 2.16; also ARKit and ARCore |
/// | ros | ahead, left, up | the same | ROS REP 103 |
/// | optical | right, down, ahead | the same | ROS REP 103, optical frames; SLAM without gravity, KITTI |
/// | euroc-imu | ahead, left, up | up, right, ahead | EuRoC MAV, body frame of its sensor |
/// | unity | right, up, ahead; left-handed | the same | Unity manual |
/// | unreal | ahead, right, up; left-handed, cm | the same | Unreal Engine documentation |
/// | ned | ahead, right, down | the same | AirSim, TartanAir |
#pragma once

#include <string>
#include <string_view>

#include "stereo/base/expected.h"
#include "stereo/math/spaces.h"

namespace farshade {

struct Axes {
  std::string name = "openxr";
  glm::dmat3 stage_from_world{1.0};  ///< a permutation of axes with signs
  glm::dmat3 head_from_body{
      1.0};                    ///< the same for the axes of the head; its determinant is that of the other
  double units_a_metre = 1.0;  ///< of the convention's positions
};

/// The conventions that are worth a try if a recording lies on its side: all named ones and ros/optical.
inline constexpr std::string_view kTriedAxes[] = {"openxr", "ros",    "optical", "euroc-imu",
                                                  "unity",  "unreal", "ned",     "ros/optical"};

/// `text` is a named convention, or WORLD/HEAD with the names of two conventions, as in `ros/optical` for a
/// camera in a world with z up. Refuses other words, and two conventions of different handedness.
[[nodiscard]] Expected<Axes> parse_axes(std::string_view text);

/// The pose, whose numbers have these axes, with the axes of the stage. Keeps every bit if they are the same.
[[nodiscard]] Rigid<Recorded, Head> in_stage(const Axes& axes, const Rigid<Recorded, Head>& pose);

}  // namespace farshade
