/// The resolution of a view, a parameter of FLIP (stereo/metrics/flip.h).
#pragma once

#include <cmath>
#include <numbers>

#include "stereo/frame/view.h"

namespace farshade {

/// Pixels per degree in the middle of the view.
[[nodiscard]] inline double pixels_per_degree(const View& view) {
  const FovTangents tangents = tangents_of(view.fov);
  const double x = view.size.width / std::abs(tangents.right_tan - tangents.left_tan),
               y = view.size.height / std::abs(tangents.down_tan - tangents.up_tan);
  return std::sqrt(x * y) * std::numbers::pi / 180;
}

}  // namespace farshade
