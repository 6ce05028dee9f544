/// LightChanges: what a viewer has changed about a scene's lights since its file was loaded. A change is a
/// light's whole new state, so that applying it twice, late, or after a lost one gives the same scene; both
/// sides agree on the lights by agreeing on a revision.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "stereo/math/spaces.h"

namespace farshade {

struct LightPose {
  Point<Stage> position;
  Vector<Stage> direction{{0, 0, -1}};  ///< unit, the way the light travels
  friend bool operator==(const LightPose&, const LightPose&) = default;
};

struct LightChange {
  std::uint32_t light = 0;        ///< index in the light set
  std::uint32_t revision = 0;     ///< of the light set that it made
  bool on = true;                 ///< a light that is off shines nowhere: its mask bits are 0
  std::optional<LightPose> pose;  ///< none: where the scene has it at its time
  friend bool operator==(const LightChange&, const LightChange&) = default;
};

/// The scene as its file has it is revision 1; each change makes the next.
inline constexpr std::uint32_t kFirstLightSet = 1;

struct LightChanges {
  std::uint32_t revision = kFirstLightSet;  ///< ordered by serial difference, like FrameId
  std::vector<LightChange> lights;          ///< the newest of each light that ever changed, by revision
  friend bool operator==(const LightChanges&, const LightChanges&) = default;
};

}  // namespace farshade
