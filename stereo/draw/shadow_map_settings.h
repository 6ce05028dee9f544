/// ShadowMapSettings: how a client that has no server draws its own shadows - one depth map a light, six for
/// a light that shines all around - and how much memory that may take.
#pragma once

#include <cstdint>

#include "stereo/scene/scene.h"

namespace farshade {

/// When maps are drawn anew.
enum class Redraw : std::uint8_t {
  WhenMoved,  ///< a light or an instance stands elsewhere than when they were drawn, or a light went on
  Always,     ///< in every frame
};

struct ShadowMapSettings {
  std::uint32_t side_px = 1024;  ///< of a map, or of one face of a cube
  std::uint32_t pcf_radius = 1;  ///< texels: (2r+1)^2 comparisons, weighed by a box 2r texels wide; 0 = one
  Redraw redraw = Redraw::WhenMoved;
  friend bool operator==(const ShadowMapSettings&, const ShadowMapSettings&) = default;
};

inline constexpr std::uint32_t kLeastMapSide_px = 32, kMostMapSide_px = 8192, kMostPcfRadius = 8;

/// What all maps of a scene may take together.
inline constexpr std::uint64_t kMostShadowMapBytes = std::uint64_t{1} << 30;

/// Bytes of the maps of all of `scene`'s lights. Refuses (Fault::OutOfRange) a side or radius outside of the
/// limits above and (Fault::Unavailable) maps that would take more than kMostShadowMapBytes, and says which
/// side would do. A renderer is only given wishes that this does not refuse.
[[nodiscard]] Expected<std::uint64_t> shadow_map_bytes(const Scene& scene, const ShadowMapSettings& wish);

}  // namespace farshade
