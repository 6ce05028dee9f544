#include "vr_client/preview/composition.h"

#include <algorithm>
#include <cmath>

#include "stereo/base/check.h"

namespace farshade {
namespace {

/// The largest size of this aspect ratio within `cell`, or the eye's own size if that is nearly as large.
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

SharedColumns shared_columns(const PerEye<EyeFov>& fov, double eye_distance_m, Extent eye) {
  // A point kScreen_m ahead lies half an eye distance to the right of the left eye and to the left of the
  // right eye.
  const double half = eye_distance_m / 2 / kScreen_m;
  const PerEye<FovTangents> window{tangents_of(fov[0]), tangents_of(fov[1])};
  const PerEye<double> left{window[0].left_tan - half, window[1].left_tan + half};
  const double column = (window[0].right_tan - window[0].left_tan) / eye.width;
  const auto skipped = [&](std::size_t side) {
    const double columns = std::round((std::max(left[0], left[1]) - left[side]) / column);
    return static_cast<std::uint32_t>(std::min(columns, double{1} * eye.width));
  };
  const PerEye<std::uint32_t> first{skipped(0), skipped(1)};
  const std::uint32_t most = std::max(first[0], first[1]);
  return most < eye.width ? SharedColumns{first, eye.width - most} : SharedColumns{};
}

ShownPart shown_part(const Composition& composition, Extent eye) {
  ShownPart part{eye, composition.aspect};
  if (composition.layout != StereoLayout::Anaglyph || composition.shared.count == 0) return part;
  part.aspect *= static_cast<double>(composition.shared.count) / eye.width;
  part.size.width = composition.shared.count;
  return part;
}

std::optional<PixelOfEye> pixel_at(const Composition& composition, Extent window, Extent eye,
                                   glm::dvec2 place) {
  const auto [size, aspect] = shown_part(composition, eye);
  for (const Panel& panel :
       panel_rects(left_of(window, composition.right_px), size, aspect, composition.layout)) {
    const glm::dvec2 within =
        (place - glm::dvec2(panel.left, panel.top)) / glm::dvec2(panel.size.width, panel.size.height);
    if (within.x < 0 || within.y < 0 || within.x >= 1 || within.y >= 1) continue;
    glm::uvec2 pixel(within * glm::dvec2(size.width, size.height));
    if (size.width != eye.width) pixel.x += composition.shared.first[0];
    return PixelOfEye{panel.eye, pixel};
  }
  return std::nullopt;
}

std::vector<Panel> panel_rects(Extent window, Extent eye, double aspect, StereoLayout layout) {
  check(eye.pixels() > 0 && aspect > 0, "the eye has pixels and an aspect ratio");
  const bool two = layout == StereoLayout::SideBySide || layout == StereoLayout::CrossEyed;
  const Extent cell{two ? window.width / 2 : window.width, window.height};
  const Extent size = fitted(cell, eye, aspect);
  if (size.pixels() == 0) return {};
  std::vector<Panel> panels;
  for (std::uint32_t place = 0; place < (two ? 2u : 1u); ++place)
    panels.push_back({.left = place * cell.width + (cell.width - size.width) / 2,
                      .top = (cell.height - size.height) / 2,
                      .size = size,
                      .eye = layout == StereoLayout::CrossEyed ? 1u - place : place});
  return panels;
}

}  // namespace farshade
