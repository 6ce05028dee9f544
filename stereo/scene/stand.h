/// Stand: where a user places the head, instead of at the scene's viewpoint.
#pragma once

#include <optional>
#include <string_view>

#include "stereo/scene/viewpoint.h"

namespace farshade {

struct Stand {
  Point<Stage> at;
  std::optional<double> heading_rad;  ///< about +y, from -z to the left; none: as at the viewpoint
  friend bool operator==(const Stand&, const Stand&) = default;
};

/// Parses the value of --stand: X,Y,Z in metres and perhaps a heading in degrees. Malformed or OutOfRange
/// otherwise.
[[nodiscard]] Expected<Stand> parse_stand(std::string_view text);

/// The scene's viewpoint (viewpoint.h), or level at `stand`.
[[nodiscard]] Rigid<Stage, Eye> viewpoint_of(const Scene& scene, const std::optional<Stand>& stand);

}  // namespace farshade
