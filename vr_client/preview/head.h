/// SimulatedHead: a head that mouse and keys move. The mouse turns it without roll. Keys move it
/// horizontally, relative to its heading, and up and down. The state is two angles and a position, so that
/// the rotation stays a unit quaternion. Moving and turning at constant rates is integrated exactly (the path
/// is an arc), so that the movement does not depend on the frame rate.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <numbers>

#include "stereo/base/clock.h"
#include "stereo/math/spaces.h"

namespace farshade {

enum class MoveSpeed : std::uint8_t { Walk, Run };

/// Input of one frame. All values must be finite.
struct HeadInput {
  glm::dvec2 turn_px{0.0};  ///< mouse movement since the last frame: +x turns right, +y looks down
  glm::dvec3 walk{0.0};     ///< right, up, back, each -1..1; a longer vector is shortened to length 1
  MoveSpeed speed = MoveSpeed::Walk;
};

/// A drag across an eye of 512 pixels turns by 90 degrees, about the fov of such an eye.
inline constexpr double kTurn_rad_per_px = 0.5 * std::numbers::pi / 512;
/// The pitch stays below 90 degrees, where the heading is undefined.
inline constexpr double kSteepestPitch_rad = 89.9 / 180 * std::numbers::pi;
/// Comfortable walking speed of adults (R. Bohannon, "Comfortable and maximum walking speed of adults",
/// 1997), and a jogging speed.
inline constexpr double kWalkingSpeed_m_per_s = 1.4, kRunningSpeed_m_per_s = 4.0;
/// A longer step counts as this one, so that a delayed frame does not move the head far.
inline constexpr Duration kLongestStep = std::chrono::milliseconds(250);

class SimulatedHead {
 public:
  /// Starts at `start` without its roll; the pitch is clamped to kSteepestPitch_rad.
  explicit SimulatedHead(const Rigid<Stage, Head>& start);

  /// Moves the head by `span` >= 0, during which `input` was given at a constant rate.
  void step(const HeadInput& input, Duration span);

  [[nodiscard]] Rigid<Stage, Head> stage_from_head() const;

 private:
  glm::dvec3 position_;
  double yaw_rad_;    ///< counter-clockwise from above, -pi..pi, 0 = along -z
  double pitch_rad_;  ///< up is positive
};

}  // namespace farshade
