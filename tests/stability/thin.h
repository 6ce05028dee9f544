/// Thin geometry: decides whether a rasteriser may see another surface than a ray through the pixel centre.
///
/// A rasteriser snaps vertices to a grid of 1/256 pixel, so geometry with an edge that close to a centre may
/// or may not cover it. Geometry that is thinner than the oracle's band passes between the five rays of the
/// band, so this test measures the distance of edges instead.
#pragma once

#include <array>
#include <vector>

#include "stereo/frame/view.h"
#include "stereo/scene/scene_state.h"

namespace farshade::stability {

using Corners = std::array<glm::dvec3, 3>;  ///< stage

[[nodiscard]] std::vector<Corners> triangles_of(const Scene& scene, const SceneState& state);

/// The surface that a ray through a pixel centre hits.
struct Met {
  Corners corners;
  double distance_m = 0;  ///< along -z
};

inline constexpr double kGrid_px = 1.0 / 64;   ///< four steps of the rasteriser's grid
inline constexpr double kSameDistance = 1e-2;  ///< relative

/// True if `distance_m` (0 = no surface) is the distance of another surface than `met` (null: no surface).
[[nodiscard]] bool is_other(double distance_m, const Met* met);

/// True if the rasteriser may see that other surface: if it is in front of `met`, an edge at that distance
/// passes within kGrid_px of the centre; if it is behind, an edge of `met` does.
[[nodiscard]] bool may_be_seen(double distance_m, const Met* met, const View& view,
                               const glm::dvec2& centre_px, const std::vector<Corners>& triangles);

}  // namespace farshade::stability
