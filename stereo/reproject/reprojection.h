/// The terms of reprojecting masks to shown views: what goes in beside masks (Reprojection) and what each
/// pixel was shaded with (ShownReport). Programs include this header; it does not know Vulkan.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "shaders/shade_data.h"
#include "shaders/shared.h"
#include "stereo/frame/traced_mask.h"

namespace farshade {

/// The number of masks of views that one draw can use, and that of all masks with those of the cube mask.
inline constexpr std::size_t kMaxMasks = FARSHADE_MAX_MASKS, kMaxTraced = FARSHADE_MAX_TRACED;

enum class Lookup : std::uint8_t {
  Reproject,  ///< projects surface points into the traced views
  Direct,     ///< reads the newest mask at the shown pixel, without regard to poses
};
enum class Eyes : std::uint8_t { This, Both };
enum class Gaps : std::uint8_t { Unknown, Neighbours };
/// The visibility near a shadow edge.
enum class Edges : std::uint8_t {
  Nearest,   ///< the bit of one pixel
  Line,      ///< 0 or 1, by the side of the edge on which the pixel's centre lies; a fraction if that is not
             ///< sure
  Coverage,  ///< the part of the pixel that lies on the lit side
  Exact,     ///< a ray of the client decides; where it cannot, as Line. Captures do not hold it
};

/// How masks are reprojected. The defaults were chosen by measurement (docs/reprojection.md).
struct Reprojection {
  Lookup lookup = Lookup::Reproject;
  Eyes eyes = Eyes::Both;        ///< the eyes whose masks a pixel may use
  Gaps gaps = Gaps::Neighbours;  ///< bits of a point that no view saw
  Edges edges = Edges::Line;     ///< visibility near a shadow edge
  friend auto operator<=>(const Reprojection&, const Reprojection&) = default;
};

/// What a pixel was shaded with: the index of a mask in use (0 = first), plus kOtherEye if that mask was
/// traced for the other eye, plus kNeighbour if its view saw only the surface beside the point; or kFirstFace
/// plus the index of a face of the cube mask; or one of the three last values. kSourceRays: the
/// newest mask does not know the point, and the client's own rays have decided all lights.
inline constexpr std::uint8_t kOtherEye = FARSHADE_MAX_MASKS, kFirstFace = FARSHADE_FIRST_FACE,
                              kNeighbour = FARSHADE_NEIGHBOUR, kSourceRays = FARSHADE_SOURCE_RAYS,
                              kSourceUnknown = FARSHADE_SOURCE_UNKNOWN,
                              kSourceUncovered = FARSHADE_SOURCE_UNCOVERED;
[[nodiscard]] constexpr bool is_face(std::uint8_t source) {
  return source >= kFirstFace && source < FARSHADE_MAX_SOURCES;
}
[[nodiscard]] constexpr bool is_mask(std::uint8_t source) {
  return source < kSourceRays;
}
/// The index of the mask that a source belongs to: those of the views, then those of the cube mask from
/// kMaxMasks on.
[[nodiscard]] constexpr std::size_t mask_of(std::uint8_t source) {
  return is_face(source) ? kMaxMasks + (source - kFirstFace) / kEyes : source % kOtherEye;
}

/// What each pixel of one eye was shaded with; pixels in row order. A light that is off has visibility 0 and
/// is neither unknown nor stale.
struct ShownReport {
  EyeMask mask;  ///< the lights with a visibility of at least one half
  std::vector<std::uint8_t> sources;
  std::vector<std::array<float, 2>> positions;  ///< of the point in the source's view, pixels
  std::vector<std::uint8_t> visibility;         ///< [pixel][light], 255 = 1; for unknown bits the guess
  /// [pixel][plane], bits as in the mask's planes: guessed; stale.
  std::vector<std::uint32_t> unknown, stale;
  /// [pixel]: how many lights would shine there without shadows. A tracer of the same view needs about as
  /// many shadow rays. It differs from a tracer's count in three ways: the tracer skips lights behind the
  /// geometric normal, traces lights of intensity 0, and rounds differently at grazing angles.
  std::vector<std::uint16_t> rays{};
};

/// A light that no mask in use knows at a pixel is shown as the newest mask has it in the direction of that
/// pixel, or with this visibility if there is no mask or the head has turned too far.
inline constexpr float kUnknownVisibility = 1.0f;

/// A mask reprojected to the views of a request.
struct RequestReprojection {
  PerEye<EyeMask> masks;      ///< bits that are asked for mean nothing
  RequestedBlocks requested;  ///< what is not known; entries for every tile
  PerEye<std::vector<BlockBits>>
      covered;  ///< blocks with a surface, for every tile; others are not asked for
};

/// Whether lights or instances can move while a session lasts.
enum class Changes : std::uint8_t { Never, Possible };

/// Whether a draw writes a ShownReport.
enum class PixelReport : std::uint8_t { Off, On };

}  // namespace farshade
