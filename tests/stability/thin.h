/// Thin things: whether a rasteriser may rightly have seen another surface than a ray through a pixel's
/// centre does.
///
/// It moves vertices to a grid of 1/256 pixel, so that what ends, or begins, that close to a centre may or
/// may not cover it. Geometry thinner than the oracle's band passes between the band's five rays; here edges
/// are measured.
#pragma once

#include <array>
#include <vector>

#include "stereo/frame/view.h"
#include "stereo/scene/scene_state.h"

namespace farshade::stability {

using Corners = std::array<glm::dvec3, 3>;  ///< stage

[[nodiscard]] std::vector<Corners> triangles_of(const Scene& scene, const SceneState& state);

/// What a ray through a pixel's centre meets.
struct Met {
  Corners corners;
  double distance_m = 0;  ///< along -z
};

inline constexpr double kGrid_px = 1.0 / 64;   ///< four steps of the rasteriser's grid
inline constexpr double kSameDistance = 1e-2;  ///< relative

/// Whether `distance_m` (0 = nothing) speaks of another surface than `met` (null: none).
[[nodiscard]] bool is_other(double distance_m, const Met* met);

/// Whether that other surface may be seen: an edge of something at that distance passes within kGrid_px of
/// the centre if it lies before `met`; an edge of `met` itself does if it lies behind.
[[nodiscard]] bool may_be_seen(double distance_m, const Met* met, const View& view,
                               const glm::dvec2& centre_px, const std::vector<Corners>& triangles);

}  // namespace farshade::stability
