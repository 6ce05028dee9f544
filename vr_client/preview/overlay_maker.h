/// OverlayMaker: draws the overlays of shown frames on a thread of its own, for frames that must not wait for
/// it. Most frames of a headset get no overlay: the next one begins when the last one is drawn.
#pragma once

#include <future>
#include <optional>

#include "vr_client/preview/controls.h"
#include "vr_client/report/measure.h"

namespace farshade {

class OverlayMaker {
 public:
  /// The share of the calling thread's time that reading frames back may take.
  static constexpr double kMostTime = 0.1;

  /// Begins the overlay that the controls choose, unless one is being drawn or was read back too recently.
  /// Reads the frame back, which waits for the device. The frame was just drawn, by the client itself and
  /// with a report.
  void begin(const FrameView& view, Renderer& renderer, const Controls& controls);

  /// The pictures of both eyes, once, when they are drawn.
  [[nodiscard]] std::optional<PerEye<Image<Rgb8>>> take();

 private:
  std::future<PerEye<Image<Rgb8>>> drawing_;  ///< its destructor waits
  std::optional<Time> next_;                  ///< when the next frame may be read back
};

}  // namespace farshade
