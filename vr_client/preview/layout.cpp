#include "vr_client/preview/layout.h"

#include <algorithm>
#include <cmath>

namespace farshade {
namespace {

constexpr Extent kLeastEye_px{480, 720};

/// At least the smallest window, at most the room; the room wins.
Extent limited(Extent size, Extent room) {
  return {std::min(std::max(size.width, kSmallestWindow.width), room.width),
          std::min(std::max(size.height, kSmallestWindow.height), room.height)};
}

}  // namespace

double text_scale(Extent window, double content_scale) {
  const double filled = std::min(static_cast<double>(window.width) / kUnscaledWindow.width,
                                 static_cast<double>(window.height) / kUnscaledWindow.height);
  const double half_steps = std::max(std::round(content_scale * 2), std::floor(filled * 2));
  return std::clamp(half_steps / 2, double{kSmallestText}, double{kLargestText});
}

Extent first_window(Extent eye, const Desktop& desktop, std::optional<Extent> remembered) {
  if (remembered) return limited(*remembered, desktop.room);
  const double scale = text_scale(desktop.room, desktop.content_scale);
  const double width = 2.0 * std::max(eye.width, kLeastEye_px.width) + kPanelWidth_px;
  const double height = std::max(eye.height, kLeastEye_px.height);
  return limited({static_cast<std::uint32_t>(std::lround(width * scale)),
                  static_cast<std::uint32_t>(std::lround(height * scale))},
                 desktop.room);
}

}  // namespace farshade
