/// SimulatedHead: a head moved by mouse and keys. The mouse turns it (no roll), keys walk it along the floor
/// where it is heading, and up and down along gravity. Its state is angles and a position, so that its
/// rotation stays unit however long the session. Walking and turning at constant rates is integrated exactly
/// (the path is an arc), so that the frame rate does not show.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <numbers>

#include "stereo/base/clock.h"
#include "stereo/math/spaces.h"

namespace farshade {

enum class Gait : std::uint8_t { Walk, Run };

/// What hands did in one frame. Finite.
struct HeadInput {
  glm::dvec2 turn_px{0.0};  ///< mouse movement since the last frame: +x right turns right, +y down looks down
  glm::dvec3 walk{0.0};     ///< right, up, back, each -1..1; longer than 1 counts as 1
  Gait gait = Gait::Walk;
};

/// A drag across an eye of 512 pixels turns by a right angle, about what such an eye shows.
inline constexpr double kTurn_rad_per_px = 0.5 * std::numbers::pi / 512;
/// Just short of straight up or down, where a head would lose its heading.
inline constexpr double kSteepestPitch_rad = 89.9 / 180 * std::numbers::pi;
/// A person's preferred pace (R. Bohannon, "Comfortable and maximum walking speed of adults", 1997) and a
/// jog.
inline constexpr double kWalkingSpeed_m_per_s = 1.4, kRunningSpeed_m_per_s = 4.0;
/// Longer steps count as this one: a hitch with a key held does not fling the head through a wall.
inline constexpr Duration kLongestStep = std::chrono::milliseconds(250);

class SimulatedHead {
 public:
  /// Where `start` is and looks. Its roll is dropped, its pitch held within kSteepestPitch_rad.
  explicit SimulatedHead(const Rigid<Stage, Head>& start);

  /// Moves on by `span` >= 0, during which `input` was given at an even rate.
  void step(const HeadInput& input, Duration span);

  [[nodiscard]] Rigid<Stage, Head> stage_from_head() const;

 private:
  glm::dvec3 position_;
  double yaw_rad_;    ///< counter-clockwise from above, -pi..pi, 0 = along -z
  double pitch_rad_;  ///< up is positive
};

}  // namespace farshade
