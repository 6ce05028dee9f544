/// Overlays: what a shown frame knows about itself, as one picture an eye, and a legend to read it by.
/// Pure: they look at the report of the shading pass and at the masks it was drawn with, never at a device.
#pragma once

#include <string>

#include "stereo/draw/shading.h"
#include "stereo/image/image.h"

namespace farshade {

enum class Overlay : std::uint8_t {
  None,       ///< the shown picture
  Source,     ///< where each pixel's shadow came from
  Age,        ///< how long ago the mask was asked for that gave it
  Unknown,    ///< what no mask knows, and what something has moved in since
  Error,      ///< the difference to the reference, eight times
  Light,      ///< the visibility of one light alone
  GuardBand,  ///< all that was traced, and where the shown view lies in it
  Rays        ///< how many shadow rays each pixel needs
};
inline constexpr std::array kOverlays{Overlay::None,  Overlay::Source, Overlay::Age,       Overlay::Unknown,
                                      Overlay::Error, Overlay::Light,  Overlay::GuardBand, Overlay::Rays};

/// As the command line, the panel and file names have it.
[[nodiscard]] constexpr const char* name_of(Overlay overlay) {
  constexpr std::array names{"none", "source", "age", "unknown", "error", "light", "guard-band", "rays"};
  static_assert(names.size() == kOverlays.size());
  return names[static_cast<std::size_t>(overlay)];
}

/// How long ago each mask that was used was asked for, newest first.
using MaskAges = std::vector<Duration>;

/// One eye of one shown frame.
struct OverlayInput {
  Side side;
  const View& view;              ///< that is shown
  const Image<Rgb8>& shown;      ///< of the view's size
  const Image<Rgb8>* reference;  ///< of the same size; null where none was traced
  const ShownReport& report;     ///< empty where the shading pass was asked for none
  const MaskAges& ages;          ///< one a mask in hand
  const TracedMask* newest;      ///< that the frame was drawn with; null where there was none
  std::uint32_t light = 0;       ///< that Overlay::Light shows
};

/// Of the shown picture's size. Not covered pixels are black, and all are where what the overlay needs is not
/// there: a report, a reference, a mask, that light.
///
/// Age and Rays use the colours of viridis (van der Walt and Smith, Matplotlib, CC0), whose lightness grows
/// all along. GuardBand draws the newest mask's view on its own plane z = -1, so that straight edges stay
/// straight, with pixels of the shape that the shown view's have; what lies where is compared by direction
/// alone.
[[nodiscard]] Image<Rgb8> overlay_picture(Overlay overlay, const OverlayInput& input);

struct LegendEntry {
  Rgb8 color;
  std::string text;
};

/// The colours of the overlay's picture and what they stand for, in the order to read them; none for None.
/// `lights` of the scene, of which Overlay::Light shows `light`.
[[nodiscard]] std::vector<LegendEntry> legend(Overlay overlay, std::uint32_t lights, std::uint32_t light);

/// Where each pixel's shadow came from: this eye's newest mask green, the other eye's cyan, older masks blue
/// to violet, all the darker the older (darkest from kOldestDrawn on); neighbours yellow; unknown orange; red
/// lines, one pixel in four, over what is stale; not covered black. `ages` one a mask in hand.
[[nodiscard]] Image<Rgb8> source_picture(const ShownReport& report, const MaskAges& ages, Extent size);

/// Where the scales of age end.
inline constexpr Duration kOldestDrawn = std::chrono::milliseconds(500);

}  // namespace farshade
