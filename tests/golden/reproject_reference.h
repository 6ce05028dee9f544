/// Reprojection in double, written from its definition and not from the shader: where a shown pixel's surface
/// point lies in a traced view, and whether that view saw the same surface there. tests/golden holds the
/// float shaders to it.
///
/// Its only inputs are views and the depth that the renderer stored for them. Normals come from that depth:
/// with p = d r, where r = (x, y, -1) runs over the window on z = -1, a plane m . p = 1 has 1/d = m . r, so
/// inverse distance is affine on the screen and its differences between pixels are the plane.
#pragma once

#include <optional>

#include "stereo/frame/eye_mask.h"
#include "stereo/frame/view.h"
#include "stereo/image/image.h"

namespace farshade {

/// One eye's view and what it saw, as Renderer::read_distance says: metres along -z, 0 = nothing.
struct SeenDepth {
  View view;
  Image<float> distance_m;
};

/// A shown surface point in the traced eye's space.
struct Carried {
  glm::dvec3 point;
  glm::dvec2 at;  ///< traced pixel position
};

/// The point behind the centre of shown pixel (x, y). Nothing if the pixel is not covered, or the point is
/// not in front of the traced eye.
[[nodiscard]] std::optional<Carried> carry(const SeenDepth& shown, std::uint32_t x, std::uint32_t y,
                                           const View& traced);

/// Whether a pixel position lies within a view of `size`.
[[nodiscard]] bool is_inside(const glm::dvec2& at, Extent size);

enum class SameSurface : std::uint8_t {
  Yes,
  No,
  Unclear,  ///< too close to a limit for float to be held to it, or no plane about the shown pixel
};

/// Whether `traced` saw the surface of shown pixel (x, y) at the pixel that its point falls on: that pixel's
/// inverse distance differs from the plane's there by no more than half of what the plane changes between
/// point and pixel centre, plus one pixel's footprint. Clear means by a factor of two, 0.02 pixels off the
/// borders of pixels, and seen at more than 3 degrees.
[[nodiscard]] SameSurface same_surface(const SeenDepth& shown, std::uint32_t x, std::uint32_t y,
                                       const SeenDepth& traced);

/// What a reprojection without the test for the same surface would show: each pixel has the bits of the
/// traced pixel that it falls on, whatever was seen there; all lights where it falls outside of the traced
/// view.
[[nodiscard]] EyeMask carried_without_test(const SeenDepth& shown, const View& traced, const EyeMask& bits);

}  // namespace farshade
