/// The cube mask: coarse masks of all directions about the head. They are traced for the six faces of a cube,
/// whose axes are those of the stage, as three requests for two opposite faces each. Wherever no mask of a
/// shown view knows a point, its bits come from a face (docs/cube-mask.md).
#pragma once

#include "stereo/frame/frame_id.h"
#include "stereo/frame/view.h"

namespace farshade {

/// Requests for a whole cube mask. Pair k has the faces in the directions +k and -k, with k = x, y, z.
inline constexpr std::size_t kCubeMaskPairs = 3;

/// A client remembers so many requests for pairs.
inline constexpr std::size_t kCubeMaskSlots = 8;

/// Requests for pairs have ids of their own, far from those of frames. They count from here; the remainder by
/// kCubeMaskPairs is the pair.
inline constexpr FrameId kFirstCubeMaskFrame{std::uint32_t{3} << 30};
[[nodiscard]] constexpr std::size_t pair_of(FrameId frame) {
  return (frame.value - kFirstCubeMaskFrame.value) % kCubeMaskPairs;
}

/// Pixels of a face's side, for shown views of `size`. A whole cube mask has at most twice the pixels of
/// both shown views, or faces of kLeastFace_px.
[[nodiscard]] Extent face_size(Extent size);
inline constexpr std::uint32_t kLeastFace_px = 16, kMostFace_px = 512;

/// The two faces of a pair. Each is wider than the face of a cube by a pixel on each side, so that the four
/// pixels around each direction are in one face.
[[nodiscard]] StereoView faces_about(Point<Stage> centre, std::size_t pair, Extent face);

}  // namespace farshade
