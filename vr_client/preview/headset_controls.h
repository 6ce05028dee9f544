/// Headset controls: what the controllers of a headset do to the viewer and to the settings of the run. The
/// sticks walk and turn the viewer by moving the tracked space in the stage. A hand takes the light that it
/// points at, and the light stays where it is in the hand. Nothing here calls OpenXR.
#pragma once

#include "vr_client/preview/controls.h"
#include "vr_client/runtime/hands.h"

namespace farshade {

/// A stick that is less far from its centre is at rest.
inline constexpr double kDeadZone = 0.2;
/// A push of the stick turns the viewer by this, at once: a smooth turn makes many people sick.
inline constexpr double kSnapTurn_rad = std::numbers::pi / 6;
/// A light farther than this from the direction in which the hand points is not taken. A light nearer than
/// kTouch_m is taken whatever the direction.
inline constexpr double kWidestGrab_rad = 10 * std::numbers::pi / 180, kTouch_m = 0.1;

/// An input between these two is what it was: pressed or released.
struct Threshold {
  double release, press;
};
inline constexpr Threshold kGrabThreshold{0.4, 0.6}, kTurnThreshold{0.4, 0.7};

/// What lasts from one frame to the next. A button that is pressed when the session gets its focus may have
/// been pressed for another program. It is Ignored until it is released.
struct ControllerState {
  enum class Press : std::uint8_t { Released, Pressed, Ignored };
  struct Grip {
    Press press = Press::Ignored;
    std::optional<HeldLight<Hand>> light;
  };
  PerHand<Grip> grips;
  Press turn = Press::Ignored, next_overlay = Press::Ignored;
  std::optional<Time> last_frame;  ///< display time
};

/// Walks and turns the viewer, grabs, moves and releases lights, and switches overlays, in `controls`.
/// Returns the new stage_from_tracked. `lights` are those of the last shown frame. A number that is not
/// finite changes nothing; with it, a pose is unknown.
///
/// - walk: horizontal, relative to the heading of the head, up to kWalkingSpeed_m_per_s.
/// - turn: kSnapTurn_rad around the head, once for each push of the stick.
/// - grab: takes the light next to the direction of the hand, if it is on and not directional, also from the
///   other hand or the head. While the pose of the hand is unknown, the light stays where it is. When the
///   session loses its focus, the hands release all lights.
/// - ahead: walks where the hand points, while `grab` is pressed and the hand holds no light.
[[nodiscard]] Rigid<Stage, Tracked> follow_hands(const ViewerInput& viewer, ControllerState& state,
                                                 Controls& controls, const LightSet& lights);

}  // namespace farshade
