/// Exposure: the factor of all lights that makes a scene neither dark nor white, in steps of a quarter of a
/// stop. The server chooses it (stereo/exposure) and sends it in its Welcome. It is not part of the scene's
/// hash, because it follows from rays, in which two versions of Embree may differ. Ambient light keeps its
/// value.
#pragma once

#include <cmath>

namespace farshade {

struct Exposure {
  static constexpr int kMostQuarterStops = 160;  ///< a factor of 2^40, about 10^12

  int quarter_stops = 0;  ///< -kMostQuarterStops to kMostQuarterStops

  [[nodiscard]] float factor() const { return std::exp2(0.25f * static_cast<float>(quarter_stops)); }
  friend bool operator==(const Exposure&, const Exposure&) = default;
};

}  // namespace farshade
