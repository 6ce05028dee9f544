#include <fmt/format.h>

#include <algorithm>

#include "vr_client/report/overlay_colors.h"
#include "vr_client/report/overlays.h"

namespace farshade {

using namespace overlay;

namespace {

std::vector<LegendEntry> source_legend() {
  return {{kThisEyeColor, "newest mask of this eye, darker with age"},
          {reprojected_tint(kThisEyeColor), "the same, reprojected, not asked for"},
          {kOtherEyeColor, "newest mask of the other eye"},
          {older_color(1), "an older mask, the redder the older"},
          {kCubeMaskColor, "the cube mask: coarse masks of all directions"},
          {kNeighbourColor, "the nearest pixel on the same surface"},
          {kRaysColor, "the client's own rays"},
          {kUnknownColor, "unknown"},
          {kStaleColor, "red lines: outdated, something has moved"}};
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
  return {{unknown_color(1), "all lights are unknown"},
          {unknown_color(share_of(1, lights)), fmt::format("one of {} lights is unknown", lights)},
          {stale_tint(dimmed(Rgb8(255))), "outdated: something has moved"},
          {dimmed(Rgb8(255)), "known (the dimmed picture)"}};
}

std::vector<LegendEntry> light_legend(std::uint32_t light) {
  return {{grey(1), fmt::format("light {} is visible", light)},
          {grey(0.5f), "half visible"},
          {grey(0), "not visible, or off"},
          {stale_tint(grey(1)), "red tint: outdated, something has moved"},
          {kUnknownColor, "unknown"}};
}

std::vector<LegendEntry> guard_band_legend() {
  return {{kOutlineColor, "border of the shown view"},
          {grey(1), "traced: all lights are visible"},
          {grey(0), "traced: no light is visible"},
          {guard_band_tint(grey(1)), "violet tint: traced, but not shown (guard band)"},
          {kNotTracedColor, "shown, but not traced"},
          {kUnknownColor, "not arrived"}};
}

/// An entry for each number of rays, at most nine.
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
      return {{Rgb8(0), "equal"}, {Rgb8(128), "difference 16/255"}, {Rgb8(255), "difference 32/255 or more"}};
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
