/// ShadowMapSettings: how a client without a server draws its own shadows, with one depth map per light, or
/// six per point light, and a limit on their memory.
#pragma once

#include <cstdint>

#include "stereo/frame/edge_sharpness.h"
#include "stereo/scene/scene.h"

namespace farshade {

/// When shadow maps are redrawn.
enum class Redraw : std::uint8_t {
  WhenMoved,  ///< where a light or an instance has moved, or a light was switched on; needs memory
              ///< (MapLayers)
  Always,     ///< every frame, all of them
};

struct ShadowMapSettings {
  std::uint32_t side_px = 1024;  ///< of a map or a cube face
  std::uint32_t pcf_radius =
      1;  ///< texels: (2r+1)^2 comparisons, box filter 2r texels wide; 0: one comparison
  Redraw redraw = Redraw::WhenMoved;
  float sharpness = kEdgeSharpness;  ///< contrast of a filtered shadow edge, as in masks
  friend bool operator==(const ShadowMapSettings&, const ShadowMapSettings&) = default;
};

inline constexpr std::uint32_t kLeastMapSide_px = 32, kMostMapSide_px = 8192, kMostPcfRadius = 8;

/// The limit for all maps of a scene and their kept depth together.
inline constexpr std::uint64_t kMostShadowMapBytes = std::uint64_t{1} << 30;

/// The bytes of the maps of all lights of `scene`, and of depth that is kept with Redraw::WhenMoved.
/// Fault::OutOfRange if the side or the radius is outside of the limits above; Fault::Unavailable if the maps
/// exceed kMostShadowMapBytes, with a side that would fit. A renderer takes only settings for which this
/// succeeds.
[[nodiscard]] Expected<std::uint64_t> shadow_map_bytes(const Scene& scene, const ShadowMapSettings& settings);

}  // namespace farshade
