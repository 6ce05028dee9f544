/// Overlays: diagnostic pictures of a shown frame, one per eye, and legends for them. They are computed on
/// the CPU from the report of the shading pass and the masks of the frame.
#pragma once

#include <string>

#include "stereo/image/image.h"
#include "stereo/reproject/reprojection.h"

namespace farshade {

enum class Overlay : std::uint8_t {
  None,       ///< the shown picture itself
  Source,     ///< which mask each pixel's visibility was taken from
  Age,        ///< time since that mask was requested
  Unknown,    ///< pixels that no mask covers, and pixels whose visibility is outdated
  Error,      ///< the difference from the reference, times eight
  Light,      ///< the visibility of one light
  GuardBand,  ///< the whole traced view, and the shown view in it
  Rays        ///< the number of shadow rays that each pixel needs
};
inline constexpr std::array kOverlays{Overlay::None,  Overlay::Source, Overlay::Age,       Overlay::Unknown,
                                      Overlay::Error, Overlay::Light,  Overlay::GuardBand, Overlay::Rays};

/// The name on the command line, in the panel and in file names.
[[nodiscard]] constexpr const char* name_of(Overlay overlay) {
  constexpr std::array names{"none", "source", "age", "unknown", "error", "light", "guard-band", "rays"};
  static_assert(names.size() == kOverlays.size());
  return names[static_cast<std::size_t>(overlay)];
}

/// The time since the request of each mask of a frame, in the order of its masks.
using MaskAges = std::vector<Duration>;

/// One eye of one shown frame.
struct OverlayInput {
  Side side;
  const View& view;              ///< the shown view
  const Image<Rgb8>& shown;      ///< has the size of the view
  const Image<Rgb8>* reference;  ///< of the same size; null without a reference
  const ShownReport& report;     ///< empty if the shading pass made no report
  const MaskAges& ages;          ///< one entry per mask that the frame was drawn with
  const TracedMask* newest;      ///< the newest of these masks; null without a mask
  std::uint32_t light = 0;       ///< the light that Overlay::Light shows
};

/// The picture has the size of the shown one. Pixels without geometry are black. If the overlay's data is
/// missing (report, reference, mask or light), the whole picture is black.
///
/// Age and Rays use the colour map viridis (van der Walt and Smith, Matplotlib, CC0), whose lightness
/// increases monotonically. GuardBand draws the view of the newest mask on that view's plane z = -1, so that
/// straight edges stay straight; its pixels have the aspect ratio of the shown view's pixels. It relates the
/// two views by direction only, without depth.
[[nodiscard]] Image<Rgb8> overlay_picture(Overlay overlay, const OverlayInput& input);

struct LegendEntry {
  Rgb8 color;
  std::string text;
};

/// The legend of the overlay, in reading order; empty for Overlay::None. `lights` is the number of lights of
/// the scene, and `light` the one that Overlay::Light shows.
[[nodiscard]] std::vector<LegendEntry> legend(Overlay overlay, std::uint32_t lights, std::uint32_t light);

/// The picture of Overlay::Source, except that overlay_picture makes pixels paler that were reprojected, not
/// asked for. This eye's newest mask is green, the other eye's is cyan, older masks are blue to violet, the
/// cube mask is pink, neighbouring pixels yellow and unknown pixels orange. Older masks are darker, down to
/// the age kOldestDrawn. Red lines, one pixel in four, mark outdated pixels. Pixels without geometry are
/// black. `ages` has one entry per mask.
[[nodiscard]] Image<Rgb8> source_picture(const ShownReport& report, const MaskAges& ages, Extent size);

/// The end of the colour scales of age.
inline constexpr Duration kOldestDrawn = std::chrono::milliseconds(500);

}  // namespace farshade
