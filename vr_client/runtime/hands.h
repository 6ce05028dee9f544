/// Hands: the state of a headset's controllers in one frame, without the buttons that make it up. The
/// headset's runtime fills it, and vr_client/preview/headset_controls.h acts on it.
#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <optional>

#include "stereo/base/clock.h"
#include "stereo/math/spaces.h"

namespace farshade {

struct Tracked;  ///< the space in which a headset's runtime gives poses: STAGE, or LOCAL if there is none
struct Hand;     ///< a controller, which points along -z

/// Left, right.
template <class T>
using PerHand = std::array<T, 2>;

struct HandInput {
  std::optional<Rigid<Tracked, Hand>> tracked_from_hand;  ///< empty: the runtime does not know where it is
  double grab = 0;                                        ///< trigger, 0..1
  bool ahead = false;  ///< button: walk where the hand points, for controllers without sticks
};

struct Hands {
  PerHand<HandInput> hand;
  glm::dvec2 walk{0.0};       ///< stick, -1..1: +x is right, +y is ahead
  double turn = 0;            ///< stick, -1..1: + is right
  bool next_overlay = false;  ///< button
};

/// Where the viewer is at the display time of a frame, and what the hands do.
struct ViewerInput {
  Time display_time;
  Rigid<Tracked, Head> tracked_from_head;
  Rigid<Stage, Tracked> stage_from_tracked;
  std::optional<Hands> hands;  ///< empty: the session is not focused, so controllers are not for this program
};

}  // namespace farshade
