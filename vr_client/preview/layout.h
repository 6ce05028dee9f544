/// Layout: the size of the window when it opens, and the scale of its text.
#pragma once

#include <optional>

#include "stereo/base/extent.h"

namespace farshade {

/// The desktop as a new window finds it, pixels.
struct Desktop {
  Extent room;               ///< the largest window that fits beside the bars of the desktop, with its frame
  double content_scale = 1;  ///< the scale of text that the desktop asks for
};

/// Text has whole and half scales within these limits, so that it stays sharp.
inline constexpr int kSmallestText = 1, kLargestText = 4;
/// The largest window whose text is not scaled up.
inline constexpr Extent kUnscaledWindow{1600, 900};
/// A window is never opened or restored smaller than this.
inline constexpr Extent kSmallestWindow{320, 240};
/// Width of the panel at scale 1, pixels.
inline constexpr double kPanelWidth_px = 330;

/// The scale of the text in a window: that of the desktop, or more in a large window.
[[nodiscard]] double text_scale(Extent window, double content_scale);

/// The size of the first window: room for both eyes at scale 1 and the panel; small eyes are enlarged, and on
/// a large desktop everything is. A `remembered` size replaces it. Never larger than the room on the desktop.
[[nodiscard]] Extent first_window(Extent eye, const Desktop& desktop, std::optional<Extent> remembered);

}  // namespace farshade
