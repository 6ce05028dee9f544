/// HiddenArea: the part of an eye's view that its lens does not show. Nothing is drawn and nothing is asked
/// for there (docs/openxr.md).
#pragma once

#include <glm/vec2.hpp>
#include <vector>

#include "stereo/frame/view.h"

namespace farshade {

struct HiddenArea {
  /// Three for each triangle: where the rays through its corners cross the plane z = -1 of the eye (x to the
  /// right, y up). So the area does not depend on the field of view.
  std::vector<glm::vec2> corners;
  friend bool operator==(const HiddenArea&, const HiddenArea&) = default;
};

/// The least turn of the eye that `hidden_in_request` allows for.
inline constexpr double kLeastTurn_deg = 2;

/// What stays hidden in requested views, which are used for frames whose eyes are turned a little from them.
/// The turn is the widest side of the guard band, which is measured from such turns, but at least
/// kLeastTurn_deg. Each area is scaled outwards about the axis of its view, until its inner edge has moved by
/// that turn. That is enough if the seen part is convex, as that of a lens is; it need not be exact, because
/// a pixel that was not asked for is guessed as any unknown one. Nothing is hidden if the turn is too large
/// for a scale, or the area holds the axis.
[[nodiscard]] PerEye<HiddenArea> hidden_in_request(const PerEye<HiddenArea>& hidden, const StereoView& shown,
                                                   const StereoView& requested);

}  // namespace farshade
