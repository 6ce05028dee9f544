/// How the heads of a recording stand and walk. A head that is worn is upright on average, hardly ever rolls,
/// and walks where it looks. Positions and rotations that are read with wrong axes do not.
#pragma once

#include <span>

#include "stereo/head/head_recording.h"

namespace farshade {

/// From worst to best.
enum class Posture : std::uint8_t {
  LiesDown,    ///< the mean up direction of the heads is far from +y
  WalksAside,  ///< upright, but it walks steadily to a direction that it does not look at
  Upright,
  WalksAhead,  ///< upright, and it walks steadily to where it looks
};

/// `most_off_rad`: how far the mean up direction may be from +y.
[[nodiscard]] Posture posture_of(std::span<const HeadSample> samples, double most_off_rad);

/// The shortest rotation that takes the up direction of the recorded world to +y: the direction nearest +y
/// about which the heads do not roll. A recording that looks in one direction only tells nothing about pitch,
/// so its pitch stays.
[[nodiscard]] glm::dquat levelling(std::span<const HeadSample> samples);

/// How widely the heads turn about the vertical, from 0 (one direction) to 1/2 (all directions equally): the
/// second eigenvalue of the mean outer product of their right directions. Only a wide turn tells the
/// direction about which heads do not roll from the axis of a neck that is bent.
[[nodiscard]] double turn_width(std::span<const HeadSample> samples);

/// Rotates everything about the first head.
void turn(std::span<HeadSample> samples, const glm::dquat& rotation);

}  // namespace farshade
