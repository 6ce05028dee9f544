#include "vr_client/report/overlays.h"

#include <algorithm>
#include <bit>
#include <glm/mat3x3.hpp>
#include <optional>

#include "stereo/base/check.h"
#include "stereo/frame/pose_delta.h"
#include "stereo/frame/tiles.h"
#include "stereo/image/difference.h"
#include "vr_client/report/overlay_colors.h"

namespace farshade {

using namespace overlay;

namespace {

/// Age reduces the brightness of a source's colour by at most this share, so that the colour stays
/// recognisable.
constexpr float kAgeDarkens = 0.65f;

/// Is any bit of the pixel's words set?
bool any_at(const std::vector<std::uint32_t>& words, std::size_t planes, std::size_t pixel) {
  std::uint32_t bits = 0;
  for (std::size_t plane = 0; plane < planes; ++plane) bits |= words[pixel * planes + plane];
  return bits != 0;
}

std::size_t count_at(const std::vector<std::uint32_t>& words, std::size_t planes, std::size_t pixel) {
  int count = 0;
  for (std::size_t plane = 0; plane < planes; ++plane) count += std::popcount(words[pixel * planes + plane]);
  return static_cast<std::size_t>(count);
}

bool bit_at(const std::vector<std::uint32_t>& words, std::size_t planes, std::size_t pixel,
            std::uint32_t light) {
  return (words[pixel * planes + light / 32] >> light % 32 & 1u) != 0;
}

std::size_t planes_of(const ShownReport& report) {
  return report.sources.empty() ? 0 : report.unknown.size() / report.sources.size();
}

/// Sets each covered pixel to `color_at(pixel)`. The picture is black without a report.
template <class ColorAt>
Image<Rgb8> painted(const ShownReport& report, Extent size, const ColorAt& color_at) {
  Image<Rgb8> picture(size);
  if (report.sources.empty()) return picture;
  check_eq(report.sources.size(), picture.pixels.size(), "pixels of the report and of the picture");
  for (std::size_t i = 0; i < picture.pixels.size(); ++i)
    if (report.sources[i] != kSourceUncovered) picture.pixels[i] = color_at(i);
  return picture;
}

Image<Rgb8> age_picture(const OverlayInput& input) {
  const auto colors =
      lookup_table(input.ages.size(), [&](std::size_t mask) { return age_color(input.ages[mask]); });
  return painted(input.report, input.shown.size, [&](std::size_t i) {
    const std::uint8_t source = input.report.sources[i];
    const std::size_t mask = mask_of(source);
    if (source == kSourceRays) return age_color(Duration::zero());
    return source == kSourceUnknown || mask >= colors.size() ? kUnknownColor : colors[mask];
  });
}

Image<Rgb8> unknown_picture(const OverlayInput& input) {
  const ShownReport& report = input.report;
  const std::size_t planes = planes_of(report), lights = report.mask.lights();
  const auto tinted =
      lookup_table(256, [](std::size_t below) { return stale_tint(Rgb8(static_cast<std::uint8_t>(below))); });
  const auto unknown =
      lookup_table(lights + 1, [&](std::size_t n) { return unknown_color(share_of(n, lights)); });
  return painted(report, input.shown.size, [&](std::size_t i) {
    if (any_at(report.unknown, planes, i)) return unknown.at(count_at(report.unknown, planes, i));
    const Rgb8 below = dimmed(input.shown.pixels[i]);
    return any_at(report.stale, planes, i) ? tinted[below.r] : below;
  });
}

Image<Rgb8> light_picture(const OverlayInput& input) {
  const ShownReport& report = input.report;
  const std::size_t planes = planes_of(report), lights = report.mask.lights();
  if (input.light >= lights) return Image<Rgb8>(input.shown.size);
  const auto seen = lookup_table(256, [](std::size_t k) { return grey(share_of(k, 255)); });
  const auto tinted = lookup_table(256, [&](std::size_t k) { return stale_tint(seen[k]); });
  return painted(report, input.shown.size, [&](std::size_t i) {
    if (bit_at(report.unknown, planes, i, input.light)) return kUnknownColor;
    const std::uint8_t k = report.visibility[i * lights + input.light];
    return bit_at(report.stale, planes, i, input.light) ? tinted[k] : seen[k];
  });
}

Image<Rgb8> rays_picture(const OverlayInput& input) {
  const std::size_t lights = input.report.mask.lights();
  const auto colors =
      lookup_table(lights + 1, [&](std::size_t rays) { return ramp(share_of(rays, lights)); });
  return painted(input.report, input.shown.size,
                 [&](std::size_t i) { return colors.at(input.report.rays[i]); });
}

// ---- Overlay::GuardBand

/// The traced view takes at most this share of the picture's width and height.
constexpr double kTracedShare = 0.8;

/// The mapping of the picture onto the plane z = -1 of the traced eye: pixel position p lies at
/// origin + p * step.
struct Chart {
  glm::dvec2 origin, step;
};

Chart chart_of(const FovTangents& shown, const FovTangents& traced, Extent size) {
  const glm::dvec2 of_shown{shown.right_tan - shown.left_tan, shown.down_tan - shown.up_tan},
      of_traced{traced.right_tan - traced.left_tan, traced.down_tan - traced.up_tan},
      pixels{size.width, size.height},
      centre{(traced.left_tan + traced.right_tan) / 2, (traced.up_tan + traced.down_tan) / 2};
  const glm::dvec2 larger = of_traced / of_shown;
  const glm::dvec2 step = of_shown / pixels * (std::max(larger.x, larger.y) / kTracedShare);
  return {centre - 0.5 * step * pixels, step};
}

/// 1 for each pixel of the chart whose direction lies in the shown view.
Image<std::uint8_t> seen_on(const Chart& chart, const View& shown, const View& traced, Extent size) {
  const FovTangents window = tangents_of(shown.fov);
  const glm::dmat3 shown_from_traced(
      glm::mat3_cast(glm::conjugate(pose_delta(shown, {}, traced, {}).traced_from_shown.rotation)));
  const glm::dvec3 along = shown_from_traced * glm::dvec3(chart.step.x, 0, 0);
  Image<std::uint8_t> seen(size);
  for (std::uint32_t y = 0; y < size.height; ++y) {
    const glm::dvec3 first =
        shown_from_traced * glm::dvec3(chart.origin + (glm::dvec2(0, y) + 0.5) * chart.step, -1.0);
    for (std::uint32_t x = 0; x < size.width; ++x) {
      const glm::dvec3 d = first + static_cast<double>(x) * along;
      const double ahead = -d.z;  // behind the eye this is negative, so that no direction passes the test
      seen.at(x, y) = (d.x >= window.left_tan * ahead) & (d.x < window.right_tan * ahead) &
                      (d.y <= window.up_tan * ahead) & (d.y > window.down_tan * ahead);
    }
  }
  return seen;
}

bool on_outline(const Image<std::uint8_t>& seen, std::uint32_t x, std::uint32_t y) {
  const std::uint8_t here = seen.at(x, y);
  return (x > 0 && seen.at(x - 1, y) != here) || (x + 1 < seen.size.width && seen.at(x + 1, y) != here) ||
         (y > 0 && seen.at(x, y - 1) != here) || (y + 1 < seen.size.height && seen.at(x, y + 1) != here);
}

/// Number of lights that are visible from the traced pixel. Nothing if its tile has not arrived.
std::optional<std::size_t> lights_lit(const TracedMask& mask, std::size_t eye, std::uint32_t x,
                                      std::uint32_t y) {
  const EyeMask& bits = mask.masks[eye];
  const std::uint32_t tile = y / kTileSide_px * TileGrid{bits.size()}.columns() + x / kTileSide_px;
  if ((known_blocks(mask, eye, tile) & block_bit(x % kTileSide_px, y % kTileSide_px)) == 0)
    return std::nullopt;
  int lit = 0;
  for (std::uint32_t plane = 0; plane < bits.layout().planes(); ++plane)
    lit += std::popcount(bits.word(x, y, plane));
  return static_cast<std::size_t>(lit);
}

/// The whole traced view, with the part that is shown marked in it.
Image<Rgb8> guard_band_picture(const OverlayInput& input) {
  const Extent size = input.shown.size;
  Image<Rgb8> picture(size);
  if (input.newest == nullptr) return picture;
  const std::size_t eye = index_of(input.side);
  const View& traced = input.newest->views[eye];
  const EyeMask& mask = input.newest->masks[eye];
  const FovTangents window = tangents_of(traced.fov);
  const Chart chart = chart_of(tangents_of(input.view.fov), window, size);
  const Image<std::uint8_t> seen = seen_on(chart, input.view, traced, size);
  const auto greys =
      lookup_table(mask.lights() + 1, [&](std::size_t lit) { return grey(share_of(lit, mask.lights())); });
  const auto tinted =
      lookup_table(greys.size(), [&](std::size_t lit) { return guard_band_tint(greys[lit]); });
  const glm::dvec2 traced_px(traced.size.width, traced.size.height),
      per_step = traced_px / glm::dvec2(window.right_tan - window.left_tan, window.down_tan - window.up_tan);
  for (std::uint32_t y = 0; y < size.height; ++y)
    for (std::uint32_t x = 0; x < size.width; ++x) {
      const glm::dvec2 on_plane = chart.origin + (glm::dvec2(x, y) + 0.5) * chart.step,
                       at = (on_plane - glm::dvec2(window.left_tan, window.up_tan)) * per_step;
      const bool is_traced = at.x >= 0 && at.y >= 0 && at.x < traced_px.x && at.y < traced_px.y;
      const bool is_seen = seen.at(x, y) != 0;
      Rgb8& color = picture.at(x, y);
      if (on_outline(seen, x, y)) {
        color = kOutlineColor;
      } else if (is_traced) {
        const auto lit = lights_lit(*input.newest, eye, static_cast<std::uint32_t>(at.x),
                                    static_cast<std::uint32_t>(at.y));
        color = !lit ? kUnknownColor : is_seen ? greys[*lit] : tinted[*lit];
      } else if (is_seen) {
        color = kNotTracedColor;
      }
    }
  return picture;
}

/// Makes the pixels paler whose bits in this eye's newest mask were reprojected, not asked for.
void mark_reprojected(const OverlayInput& input, Image<Rgb8>& picture) {
  if (input.newest == nullptr || input.newest->requested == nullptr || input.report.sources.empty()) return;
  const std::size_t eye = index_of(input.side);
  const TileGrid grid{input.newest->views[eye].size};
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    if (input.report.sources[i] != 0) continue;
    const auto x = static_cast<std::uint32_t>(input.report.positions[i][0]),
               y = static_cast<std::uint32_t>(input.report.positions[i][1]);
    const BlockBits requested =
        input.newest->requested->at(eye, y / kTileSide_px * grid.columns() + x / kTileSide_px);
    if ((requested & block_bit(x % kTileSide_px, y % kTileSide_px)) == 0)
      picture.pixels[i] = reprojected_tint(picture.pixels[i]);
  }
}

}  // namespace

Image<Rgb8> source_picture(const ShownReport& report, const MaskAges& ages, Extent size) {
  const std::size_t planes = planes_of(report);
  const auto colors = lookup_table(kSourceUncovered, [&](std::size_t source) {
    const auto mask = mask_of(static_cast<std::uint8_t>(source));
    if (source == kSourceRays) return kRaysColor;
    if (source == kSourceUnknown || mask >= ages.size()) return kUnknownColor;
    const Rgb8 fresh = source >= kNeighbour ? kNeighbourColor
                       : mask >= kMaxMasks  ? kCubeMaskColor
                       : mask > 0           ? older_color(mask)
                       : source == 0        ? kThisEyeColor
                                            : kOtherEyeColor;
    return scaled(
        fresh,
        1.0f - kAgeDarkens *
                   std::min(static_cast<float>(seconds_of(ages[mask]) / seconds_of(kOldestDrawn)), 1.0f));
  });
  Image<Rgb8> picture = painted(report, size, [&](std::size_t i) { return colors[report.sources[i]]; });
  for (std::uint32_t y = 0; y < size.height && planes > 0; ++y)
    for (std::uint32_t x = (4 - y % 4) % 4; x < size.width; x += 4)
      if (any_at(report.stale, planes, std::size_t{y} * size.width + x)) picture.at(x, y) = kStaleColor;
  return picture;
}

Image<Rgb8> overlay_picture(Overlay overlay, const OverlayInput& input) {
  check(input.shown.size == input.view.size, "the shown picture is of the shown view");
  switch (overlay) {
    case Overlay::None:
      return input.shown;
    case Overlay::Source: {
      Image<Rgb8> picture = source_picture(input.report, input.ages, input.shown.size);
      mark_reprojected(input, picture);
      return picture;
    }
    case Overlay::Age:
      return age_picture(input);
    case Overlay::Unknown:
      return unknown_picture(input);
    case Overlay::Error:
      return input.reference ? difference_x8(input.shown, *input.reference) : Image<Rgb8>(input.shown.size);
    case Overlay::Light:
      return light_picture(input);
    case Overlay::GuardBand:
      return guard_band_picture(input);
    case Overlay::Rays:
      break;
  }
  return rays_picture(input);
}

}  // namespace farshade
