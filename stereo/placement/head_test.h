/// HeadTest: does a recorded head see the scene where it is placed, or is it inside of walls and furniture?
///
/// A pose is inside geometry if one of these holds:
/// - A surface lies between the two eyes, or nearer than 1 cm to one of them.
/// - More than half of the rays around the eyes first meet the inside of a solid: the back of a single-sided
///   surface, or the back of a double-sided surface nearer than 0.5 m. Walls are often double-sided and wound
///   either way, so a back further away may be that of a room.
///
/// Otherwise a pose sees nothing if less than 1 % of the rays through both pictures meet a surface that is
/// visible from their side, and if neither eye sees the scene from outside as a thing of at least half a
/// degree in its picture.
#pragma once

#include <span>
#include <string>

#include "stereo/frame/view.h"
#include "stereo/head/head_recording.h"
#include "stereo/placement/surroundings.h"

namespace farshade {

enum class PoseVerdict : std::uint8_t { Sees, InsideGeometry, SeesNothing };

/// The verdict on one pose of a head.
[[nodiscard]] PoseVerdict judge(const Surroundings& surroundings, const StereoView& eyes);

/// The verdict on one pose of the recorded head.
[[nodiscard]] PoseVerdict judge(const Surroundings& surroundings, const HeadRecording& recording,
                                const Rigid<Stage, Head>& stage_from_head);

/// Rays through the middles of a grid of `across` x `across` cells over each eye's picture.
[[nodiscard]] std::vector<Ray> picture_rays(const HeadRecording& recording,
                                            const Rigid<Stage, Head>& stage_from_head, int across);

struct HeadTest {
  std::size_t tested = 0, inside = 0, see_nothing = 0;  ///< numbers of poses

  /// More than 5 % of the poses are inside geometry or see nothing.
  [[nodiscard]] bool is_bad() const { return 20 * (inside + see_nothing) > tested; }
};

/// The part of a recording that is shown, since its start.
struct Shown {
  Duration from{}, until{};
};

/// Judges at most 64 poses, evenly over the shown part.
[[nodiscard]] HeadTest test_head(const Surroundings& surroundings, const HeadRecording& recording,
                                 const Rigid<Stage, Recorded>& stage_from_recorded, const Shown& shown);

/// Judges at most 64 of these views, evenly.
[[nodiscard]] HeadTest test_views(const Surroundings& surroundings, std::span<const StereoView> views);

/// "of 64 poses of the head, 12 % are inside geometry and 3 % see nothing"
[[nodiscard]] std::string in_words(const HeadTest& test);

/// `count` directions, evenly over the sphere (a spiral of the golden angle).
[[nodiscard]] std::vector<Vector<Stage>> directions_around(int count);

}  // namespace farshade
