/// A reference for reprojection in double, written from the definition and not from the shader. It computes
/// where a shown pixel's surface point is in a traced view, and whether that view saw the same surface there.
/// Tests compare the float shaders with it.
///
/// Its only inputs are views and the depth that the renderer stored for them. It computes normals from that
/// depth. Let p = d r, where r = (x, y, -1) is a point of the window on z = -1. Then a plane m . p = 1 has
/// 1/d = m . r. So inverse distance is affine on the screen, and its differences between pixels give the
/// plane.
#pragma once

#include <optional>

#include "stereo/frame/eye_mask.h"
#include "stereo/frame/view.h"
#include "stereo/image/image.h"

namespace farshade {

/// A view of one eye and the distances of its pixels: metres along -z, 0 for uncovered pixels.
struct EyeDepth {
  View view;
  Image<float> distance_m;
};

/// A shown surface point in the traced eye.
struct ReprojectedPixel {
  glm::dvec3 point;
  glm::dvec2 at;  ///< traced pixel position
};

/// The surface point at the centre of shown pixel (x, y). Empty if the pixel is not covered, or if the point
/// is not in front of the traced eye.
[[nodiscard]] std::optional<ReprojectedPixel> reproject(const EyeDepth& shown, std::uint32_t x,
                                                        std::uint32_t y, const View& traced);

/// Whether a pixel position is within a view of `size`.
[[nodiscard]] bool is_inside(const glm::dvec2& at, Extent size);

enum class SameSurface : std::uint8_t {
  Yes,
  No,
  Unclear,  ///< too close to a limit for float to decide, or no plane around the shown pixel
};

/// Whether `traced` saw the surface of shown pixel (x, y) at the pixel that contains its point: that pixel's
/// inverse distance may differ from the plane's there by half of the plane's change between point and pixel
/// centre, plus one pixel's footprint. The result is Unclear within a factor of two of that limit, within
/// 0.02 pixels of a pixel border, and at grazing angles below 3 degrees.
[[nodiscard]] SameSurface same_surface(const EyeDepth& shown, std::uint32_t x, std::uint32_t y,
                                       const EyeDepth& traced);

/// The mask of a reprojection without the same-surface test: each pixel has the bits of the traced pixel that
/// contains its point, whatever was seen there, and all bits set if the point is outside of the traced view.
[[nodiscard]] EyeMask reprojected_without_test(const EyeDepth& shown, const View& traced,
                                               const EyeMask& bits);

}  // namespace farshade
