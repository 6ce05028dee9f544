/// LightChanges: the changes that a user made to the lights of a scene. A change holds the complete new state
/// of a light, so that the result does not depend on duplicated, late or lost changes. Client and server have
/// the same lights if they have the same revision.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "stereo/frame/frame_id.h"
#include "stereo/math/spaces.h"

namespace farshade {

struct LightPose {
  Point<Stage> position;
  Vector<Stage> direction{{0, 0, -1}};  ///< unit, the direction in which the light travels
  friend bool operator==(const LightPose&, const LightPose&) = default;
};

struct LightChange {
  std::uint32_t light = 0;        ///< index in the light set
  std::uint32_t revision = 0;     ///< revision of the light set after this change
  bool on = true;                 ///< if off, the light lights nothing and its mask bits are 0
  std::optional<LightPose> pose;  ///< none: the pose that the scene gives it
  friend bool operator==(const LightChange&, const LightChange&) = default;
};

/// The revision of the unchanged scene. Each change increments the revision.
inline constexpr std::uint32_t kFirstLightSet = 1;

struct LightChanges {
  std::uint32_t revision = kFirstLightSet;  ///< ordered by serial difference, like FrameId
  std::vector<LightChange> lights;          ///< the newest change of each changed light, sorted by revision
  friend bool operator==(const LightChanges&, const LightChanges&) = default;
};

/// Serial order of light set revisions, like that of FrameId.
[[nodiscard]] constexpr bool is_newer_light_set(std::uint32_t a, std::uint32_t b) {
  return is_newer(FrameId{a}, FrameId{b});
}

/// Adds the next revision: `light` is on or off, and at `pose` or at the pose that the scene gives it.
void change(LightChanges& changes, std::uint32_t light, bool on, const std::optional<LightPose>& pose);

/// The update for a receiver that has `revision`: the changes after it, at most `most` of them, oldest first.
/// The receiver has the revision of the update afterwards: every light whose newest change is not newer is
/// correct. If nothing was left out, it is changes.revision.
[[nodiscard]] LightChanges since(const LightChanges& changes, std::uint32_t revision, std::size_t most);

/// The changes up to `revision`: those that a receiver with `revision` has for certain.
[[nodiscard]] LightChanges up_to(const LightChanges& changes, std::uint32_t revision);

/// Applies an update that was made for the revision of `held` or an older one. An update that is not newer
/// than `held` has no effect, so updates may be duplicated, late or lost.
void merge(LightChanges& held, const LightChanges& update);

}  // namespace farshade
