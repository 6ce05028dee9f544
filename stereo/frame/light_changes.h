/// LightChanges: what a viewer has changed about a scene's lights since its file was loaded. A change is a
/// light's whole new state, so that applying it twice, late, or after a lost one gives the same scene; both
/// sides agree on the lights by agreeing on a revision.
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

/// Serial order of light set revisions, as FrameId's.
[[nodiscard]] constexpr bool is_newer_light_set(std::uint32_t a, std::uint32_t b) {
  return is_newer(FrameId{a}, FrameId{b});
}

/// Makes the next revision: from now on `light` is on or off, and at `pose` or where the scene has it.
void change(LightChanges& changes, std::uint32_t light, bool on, const std::optional<LightPose>& pose);

/// What somebody who holds `revision` needs: the changes after it, at most `most` of them, oldest first. The
/// update's own revision is the one that is held once it is taken: every light whose newest change is not
/// newer than it is then right. It is changes.revision where nothing was left out.
[[nodiscard]] LightChanges since(const LightChanges& changes, std::uint32_t revision, std::size_t most);

/// What somebody who holds `revision` surely has right: the changes up to it.
[[nodiscard]] LightChanges up_to(const LightChanges& changes, std::uint32_t revision);

/// Takes an update that was made for a revision that `held` has or is beyond. One that is not newer than
/// `held` changes nothing, so updates may come twice, late or never.
void merge(LightChanges& held, const LightChanges& update);

}  // namespace farshade
