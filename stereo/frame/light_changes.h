/// LightChanges: the lights that a viewer has changed since the scene's file was loaded. A change holds the
/// light's whole new state. So a receiver may apply changes twice or late, and may miss earlier ones, and
/// still has the right lights. Client and server agree on the lights when they agree on a LightSetRevision.
#pragma once

#include <cstddef>
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

/// Number of a state of the light set. Every change of a light makes the next revision.
struct LightSetRevision {
  std::uint32_t value = 0;
  friend bool operator==(LightSetRevision, LightSetRevision) = default;
};

/// The revision of the lights as the scene's file has them.
inline constexpr LightSetRevision kFirstLightSet{1};

/// Serial order (RFC 1982), as for FrameId: right across wraparound.
[[nodiscard]] constexpr bool is_newer(LightSetRevision a, LightSetRevision b) {
  return static_cast<std::int32_t>(a.value - b.value) > 0;
}

[[nodiscard]] constexpr LightSetRevision next(LightSetRevision revision) {
  return {revision.value + 1};
}

struct LightChange {
  std::uint32_t light = 0;        ///< index in the light set
  LightSetRevision revision{};    ///< the revision that this change made
  bool on = true;                 ///< false: the light shines nowhere and its mask bits are 0
  std::optional<LightPose> pose;  ///< none: the light is where the scene's animation places it
  friend bool operator==(const LightChange&, const LightChange&) = default;
};

struct LightChanges {
  LightSetRevision revision = kFirstLightSet;  ///< the newest one
  std::vector<LightChange> lights;             ///< the newest change of each changed light, by revision
  friend bool operator==(const LightChanges&, const LightChanges&) = default;
};

/// Makes the next revision, in which `light` is on or off, at `pose` or where the scene places it.
void change(LightChanges& changes, std::uint32_t light, bool on, const std::optional<LightPose>& pose);

/// The update for a receiver that holds `revision`: the changes after it, oldest first, at most `most`. The
/// update's own revision is the one that the receiver holds afterwards: every light whose newest change is
/// not newer than that revision is then right. It equals changes.revision if the update has all changes.
[[nodiscard]] LightChanges since(const LightChanges& changes, LightSetRevision revision, std::size_t most);

/// The changes that a receiver that holds `revision` surely has: those up to it.
[[nodiscard]] LightChanges up_to(const LightChanges& changes, LightSetRevision revision);

/// Applies an update that was made for `held`'s revision or an older one. An update that is not newer than
/// `held` changes nothing, so updates may arrive twice, late or never.
void merge(LightChanges& held, const LightChanges& update);

}  // namespace farshade
