#include "vr_client/report/overlays.h"

#include <algorithm>
#include <bit>

#include "stereo/base/check.h"
#include "stereo/image/difference.h"
#include "vr_client/report/guard_band_picture.h"
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
    return source == kSourceUnknown ? kUnknownColor : colors.at(source % kOtherEye);
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

}  // namespace

Image<Rgb8> source_picture(const ShownReport& report, const MaskAges& ages, Extent size) {
  const std::size_t planes = planes_of(report);
  const auto colors = lookup_table(kSourceUncovered, [&](std::size_t source) {
    const std::size_t mask = source % kOtherEye;
    if (source == kSourceUnknown || mask >= ages.size()) return kUnknownColor;
    const Rgb8 fresh = source >= kNeighbour ? kNeighbourColor
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

}  // namespace farshade
