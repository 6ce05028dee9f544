/// Fit: places a recorded head in the free space around a reference, and scales its walk down as far as
/// needed.
///
/// The free space is what a ray from the reference reaches, so it is the same room. A candidate is an anchor
/// in it and a point of the recording that comes to lie there: first the recording's start at the reference,
/// then the middle of the walk at the reference and at points around it. A ray from the anchor to each
/// recorded position says how far the walk may reach in that direction; the walk is then scaled down until
/// 0.15 m around its poses are free. The largest scale wins, at most 1; among equal ones the first candidate.
/// The search goes on around the best anchor while that helps. It has no random choice, and its work has a
/// limit.
#pragma once

#include "stereo/head/head_recording.h"
#include "stereo/placement/surroundings.h"

namespace farshade {

struct Fit {
  double scale = 1;                            ///< of the recorded positions; at most 1
  Rigid<Stage, Recorded> stage_from_recorded;  ///< of the scaled recording
  double moved_m = 0;                          ///< from the reference to the head's first position
};

enum class Anchors : std::uint8_t {
  Around,     ///< the reference and places around it
  Reference,  ///< the recording starts at the reference
};

/// The head looks as at `reference`, and its direction of gravity stays. OutOfRange if there is no free
/// space: the reference is inside geometry (head_test.h), or it and every place around it are closer than
/// 0.15 m to a surface.
[[nodiscard]] Expected<Fit> fit_head(const Surroundings& surroundings, const HeadRecording& recording,
                                     const Rigid<Stage, Eye>& reference, Anchors anchors = Anchors::Around);

/// The recording with its positions multiplied by `scale`. Rotations and eye distance stay.
[[nodiscard]] HeadRecording scaled(HeadRecording recording, double scale);

}  // namespace farshade
