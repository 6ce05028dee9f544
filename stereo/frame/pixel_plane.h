/// A plane of pixels that is sent: one number per pixel. It is a layer of a G-buffer, or a coordinate of the
/// surface points.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "stereo/frame/view.h"

namespace farshade {

/// The meaning of a plane's words. The values are part of the wire format.
enum class PlaneKind : std::uint8_t { BaseColor, Normal, Depth, PositionX, PositionY, PositionZ };

inline constexpr std::uint32_t kMaxPlaneWord_bytes = 4;

struct PixelPlane {
  Extent size;
  std::uint32_t word_bytes = kMaxPlaneWord_bytes;  ///< 1 to kMaxPlaneWord_bytes
  std::vector<std::uint32_t> words;                ///< row by row, none longer than word_bytes

  PixelPlane() = default;
  /// All words 0.
  PixelPlane(Extent of, std::uint32_t bytes) : size(of), word_bytes(bytes), words(of.pixels()) {}
  friend bool operator==(const PixelPlane&, const PixelPlane&) = default;
};

/// The G-buffer of both eyes as it is sent: base colour as stored in the image (3 bytes), normal (4), depth
/// (bits of a float, reversed z, 4; 0 without a surface).
struct GBufferPlanes {
  PerEye<PixelPlane> base_color, normal, depth;
  friend bool operator==(const GBufferPlanes&, const GBufferPlanes&) = default;
};
inline constexpr std::array kGBufferKinds{PlaneKind::BaseColor, PlaneKind::Normal, PlaneKind::Depth};

/// The plane of a kind in kGBufferKinds.
[[nodiscard]] constexpr auto& planes_of(auto& gbuffer, PlaneKind kind) {
  return kind == PlaneKind::BaseColor ? gbuffer.base_color
         : kind == PlaneKind::Normal  ? gbuffer.normal
                                      : gbuffer.depth;
}

}  // namespace farshade
