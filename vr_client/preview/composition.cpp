#include "vr_client/preview/composition.h"

#include <algorithm>
#include <cmath>

#include "stereo/base/check.h"

namespace farshade {
namespace {

/// The largest size of this aspect within `cell`, or the eye's own where that is nearly as large.
Extent fitted(Extent cell, Extent eye, double aspect) {
  const double height = std::min(double{1} * cell.height, cell.width / aspect);
  const bool square_pixels = std::abs(eye.height * aspect - eye.width) < 0.5;
  if (square_pixels && eye.width <= cell.width && height > eye.height - 0.5 &&
      height < eye.height * kFillScale)
    return eye;
  return {std::min(cell.width, static_cast<std::uint32_t>(std::lround(height * aspect))),
          static_cast<std::uint32_t>(std::lround(height))};
}

}  // namespace

std::vector<Panel> panel_rects(Extent window, Extent eye, double aspect, Way way) {
  check(eye.pixels() > 0 && aspect > 0, "an eye has pixels");
  const bool two = way == Way::SideBySide || way == Way::CrossEyed;
  const Extent cell{two ? window.width / 2 : window.width, window.height};
  const Extent size = fitted(cell, eye, aspect);
  if (size.pixels() == 0) return {};
  std::vector<Panel> panels;
  for (std::uint32_t place = 0; place < (two ? 2u : 1u); ++place)
    panels.push_back({.left = place * cell.width + (cell.width - size.width) / 2,
                      .top = (cell.height - size.height) / 2,
                      .size = size,
                      .eye = way == Way::CrossEyed ? 1u - place : place});
  return panels;
}

}  // namespace farshade
