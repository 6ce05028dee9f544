/// The contrast of filtered shadow edges, of masks and of shadow maps.
#pragma once

namespace farshade {

/// Contrast of a filtered shadow edge: factor of the visibility's distance from one half.
/// docs/reprojection.md and docs/modes.md have the measurements.
inline constexpr float kEdgeSharpness = 4.0f;

}  // namespace farshade
