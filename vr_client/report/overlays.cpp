#include "vr_client/report/overlays.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/mat3x3.hpp>
#include <optional>

#include "stereo/base/check.h"
#include "stereo/frame/pose_delta.h"
#include "stereo/frame/tiles.h"
#include "stereo/image/difference.h"

namespace farshade {
namespace {

constexpr Rgb8 kUnknownColor(255, 140, 0), kStaleColor(255, 40, 40), kThisEye(60, 220, 90),
    kOther(60, 210, 230), kBeside(240, 230, 60), kGuardBand(150, 60, 255), kOutline(0, 255, 170),
    kNotTraced(110, 20, 30);

/// What is seen of nothing: still apart from the black of what is not covered.
constexpr float kShadowGrey = 40;
/// Of the guard band's picture that the traced view takes at most; the rest is room for what it lacks.
constexpr double kTracedShare = 0.8;

/// What age takes of a source's colour at most: which source it is can be seen at any age.
constexpr float kAgeDarkens = 0.65f;

Rgb8 scaled(Rgb8 color, float by) {
  return Rgb8(glm::vec3(color) * std::clamp(by, 0.0f, 1.0f));
}

Rgb8 mixed(Rgb8 a, Rgb8 b, float of_b) {
  return Rgb8(glm::round(glm::mix(glm::vec3(a), glm::vec3(b), of_b)));
}

Rgb8 grey(float share) {
  return Rgb8(static_cast<std::uint8_t>(std::lround(kShadowGrey + (255 - kShadowGrey) * share)));
}

/// Viridis at six even steps, linear in sRGB between them; `share` within 0..1 or cut off.
Rgb8 ramp(float share) {
  constexpr std::array<glm::vec3, 6> steps{
      {{68, 1, 84}, {65, 68, 135}, {42, 120, 142}, {34, 168, 132}, {122, 209, 81}, {253, 231, 37}}};
  const float place = std::clamp(share, 0.0f, 1.0f) * (steps.size() - 1);
  const std::size_t below = std::min(static_cast<std::size_t>(place), steps.size() - 2);
  return Rgb8(glm::round(glm::mix(steps[below], steps[below + 1], place - static_cast<float>(below))));
}

float share_of(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0.0f : static_cast<float>(part) / static_cast<float>(whole);
}

Rgb8 older_color(std::size_t mask) {
  return {static_cast<std::uint8_t>(70 + 40 * mask), 90, 255};
}

Rgb8 age_color(Duration age) {
  return ramp(static_cast<float>(seconds_of(age) / seconds_of(kOldestDrawn)));
}

/// `share` of the lights, more than none.
Rgb8 unknown_color(float share) {
  return scaled(kUnknownColor, 0.4f + 0.6f * share);
}

/// Grey: the luma of Rec. 709, times 0.45 so that colours stand out.
Rgb8 dimmed(Rgb8 color) {
  return Rgb8(static_cast<std::uint8_t>((25 * color.r + 82 * color.g + 8 * color.b) >> 8));
}

Rgb8 stale_tint(Rgb8 color) {
  return mixed(color, kStaleColor, 0.5f);
}

Rgb8 guard_band_tint(Rgb8 color) {
  return mixed(color, kGuardBand, 0.5f);
}

/// Whether any bit is set in one pixel's words.
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

/// What is made of 0, 1, .. count - 1: once a picture, not once a pixel.
template <class Of>
auto table(std::size_t count, const Of& of) {
  std::vector<decltype(of(count))> made;
  for (std::size_t i = 0; i < count; ++i) made.push_back(of(i));
  return made;
}

/// Every covered pixel in `color_at(pixel)`; all black without a report.
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
  const auto colors = table(input.ages.size(), [&](std::size_t mask) { return age_color(input.ages[mask]); });
  return painted(input.report, input.shown.size, [&](std::size_t i) {
    const std::uint8_t source = input.report.sources[i];
    return source == kSourceUnknown ? kUnknownColor : colors.at(source % kOtherEye);
  });
}

Image<Rgb8> unknown_picture(const OverlayInput& input) {
  const ShownReport& report = input.report;
  const std::size_t planes = planes_of(report), lights = report.mask.lights();
  const auto tinted =
      table(256, [](std::size_t below) { return stale_tint(Rgb8(static_cast<std::uint8_t>(below))); });
  const auto unknown = table(lights + 1, [&](std::size_t n) { return unknown_color(share_of(n, lights)); });
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
  const auto seen = table(256, [](std::size_t k) { return grey(share_of(k, 255)); });
  const auto tinted = table(256, [&](std::size_t k) { return stale_tint(seen[k]); });
  return painted(report, input.shown.size, [&](std::size_t i) {
    if (bit_at(report.unknown, planes, i, input.light)) return kUnknownColor;
    const std::uint8_t k = report.visibility[i * lights + input.light];
    return bit_at(report.stale, planes, i, input.light) ? tinted[k] : seen[k];
  });
}

Image<Rgb8> rays_picture(const OverlayInput& input) {
  const std::size_t lights = input.report.mask.lights();
  const auto colors = table(lights + 1, [&](std::size_t rays) { return ramp(share_of(rays, lights)); });
  return painted(input.report, input.shown.size,
                 [&](std::size_t i) { return colors.at(input.report.rays[i]); });
}

/// The guard band's picture lies on the traced eye's plane z = -1: its pixel position p is at origin + p *
/// step.
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

/// Which of the chart's pixels the shown eye sees, by direction alone.
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
      const double ahead = -d.z;  // where it is negative the window is inside out, and nothing lies in it
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

/// How many lights the traced pixel sees; nothing where its tile has not come.
std::optional<std::size_t> lights_lit(const EyeMask& bits, const KnownTiles& known, std::uint32_t x,
                                      std::uint32_t y) {
  const std::uint32_t tile = y / kTileSide_px * TileGrid{bits.size()}.columns() + x / kTileSide_px;
  if (known[tile] != all_planes_known(bits.layout())) return std::nullopt;
  int lit = 0;
  for (std::uint32_t plane = 0; plane < bits.layout().planes(); ++plane)
    lit += std::popcount(bits.word(x, y, plane));
  return static_cast<std::size_t>(lit);
}

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
      table(mask.lights() + 1, [&](std::size_t lit) { return grey(share_of(lit, mask.lights())); });
  const auto tinted = table(greys.size(), [&](std::size_t lit) { return guard_band_tint(greys[lit]); });
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
        color = kOutline;
      } else if (is_traced) {
        const auto lit = lights_lit(mask, input.newest->known_tiles[eye], static_cast<std::uint32_t>(at.x),
                                    static_cast<std::uint32_t>(at.y));
        color = !lit ? kUnknownColor : is_seen ? greys[*lit] : tinted[*lit];
      } else if (is_seen) {
        color = kNotTraced;
      }
    }
  return picture;
}

std::vector<LegendEntry> source_legend() {
  return {{kThisEye, "this eye's newest mask, darker with age"},
          {kOther, "the other eye's newest"},
          {older_color(1), "one mask older"},
          {older_color(2), "two older"},
          {older_color(3), "three older"},
          {kBeside, "the nearest pixel on the same surface"},
          {kUnknownColor, "unknown"},
          {kStaleColor, "red lines: something has moved since"}};
}

std::vector<LegendEntry> age_legend() {
  std::vector<LegendEntry> entries;
  for (int fifth = 0; fifth <= 5; ++fifth) {
    const Duration age = kOldestDrawn / 5 * fifth;
    entries.push_back(
        {age_color(age), fmt::format("{:.0f} ms{}", seconds_of(age) * 1e3, fifth == 5 ? " or more" : "")});
  }
  entries.push_back({kUnknownColor, "unknown: no mask"});
  return entries;
}

std::vector<LegendEntry> unknown_legend(std::uint32_t lights) {
  return {{unknown_color(1), "no light is known"},
          {unknown_color(share_of(1, lights)), fmt::format("one of {} lights is not", lights)},
          {stale_tint(dimmed(Rgb8(255))), "known, but something has moved since"},
          {dimmed(Rgb8(255)), "known (the picture, dimmed)"}};
}

std::vector<LegendEntry> light_legend(std::uint32_t light) {
  return {{grey(1), fmt::format("light {} is seen", light)},
          {grey(0.5f), "half of it"},
          {grey(0), "not seen, or off"},
          {stale_tint(grey(1)), "red added: something has moved since"},
          {kUnknownColor, "unknown"}};
}

std::vector<LegendEntry> guard_band_legend() {
  return {{kOutline, "edge of the shown view"},
          {grey(1), "traced: all lights are seen"},
          {grey(0), "none is"},
          {guard_band_tint(grey(1)), "violet added: traced, not shown (guard band)"},
          {kNotTraced, "shown, not traced"},
          {kUnknownColor, "has not arrived"}};
}

/// Every number of rays, or nine of them.
std::vector<LegendEntry> rays_legend(std::uint32_t lights) {
  std::vector<LegendEntry> entries;
  const std::uint32_t last = std::min(lights, 8u);
  for (std::uint32_t i = 0; i <= last; ++i) {
    const std::uint32_t rays = last == 0 ? 0 : lights * i / last;
    entries.push_back({ramp(share_of(rays, lights)), fmt::format("{} ray{}", rays, rays == 1 ? "" : "s")});
  }
  return entries;
}

}  // namespace

Image<Rgb8> source_picture(const ShownReport& report, const MaskAges& ages, Extent size) {
  const std::size_t planes = planes_of(report);
  const auto colors = table(kSourceUncovered, [&](std::size_t source) {
    const std::size_t mask = source % kOtherEye;
    if (source == kSourceUnknown || mask >= ages.size()) return kUnknownColor;
    const Rgb8 fresh = source >= kNeighbour ? kBeside
                       : mask > 0           ? older_color(mask)
                       : source == 0        ? kThisEye
                                            : kOther;
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
    case Overlay::Source:
      return source_picture(input.report, input.ages, input.shown.size);
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

std::vector<LegendEntry> legend(Overlay overlay, std::uint32_t lights, std::uint32_t light) {
  switch (overlay) {
    case Overlay::None:
      break;
    case Overlay::Source:
      return source_legend();
    case Overlay::Age:
      return age_legend();
    case Overlay::Unknown:
      return unknown_legend(lights);
    case Overlay::Error:
      return {{Rgb8(0), "equal"}, {Rgb8(128), "16/255 apart"}, {Rgb8(255), "32/255 apart or more"}};
    case Overlay::Light:
      return light_legend(light);
    case Overlay::GuardBand:
      return guard_band_legend();
    case Overlay::Rays:
      return rays_legend(lights);
  }
  return {};
}

}  // namespace farshade
