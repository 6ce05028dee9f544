#include "stereo/frame/view.h"

#include <cmath>

namespace farshade {

bool is_valid(const View& view) {
  const glm::dquat& q = view.stage_from_eye.rotation;
  const glm::dvec3& t = view.stage_from_eye.translation;
  const bool unit = std::abs(glm::length(q) - 1.0) <= 1e-3;  // false for NaN
  const bool finite = std::isfinite(t.x) && std::isfinite(t.y) && std::isfinite(t.z);
  const auto side_ok = [](std::uint32_t side) { return side >= 1 && side <= kMaxViewSide_px; };
  return unit && finite && is_valid(view.fov) && side_ok(view.size.width) && side_ok(view.size.height);
}

}  // namespace farshade
