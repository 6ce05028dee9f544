/// Inspection: measures a shown frame against its reference and replaces the eyes' pictures by overlays or
/// differences, as the controls ask. It does no work if the controls ask for nothing.
#pragma once

#include "vr_client/preview/controls.h"
#include "vr_client/preview/pixel_facts.h"
#include "vr_client/report/measure.h"

namespace farshade {

/// Whether the shaded picture shines through this overlay. Not through those that contain it or show other
/// places.
[[nodiscard]] bool shows_through(Overlay overlay);

/// `overlay` where `share` of the brightness of `picture` shines through. Both have one size. Only the
/// brightness, so that colours remain those of the legend.
[[nodiscard]] Image<Rgb8> seen_through(Image<Rgb8> overlay, const Image<Rgb8>& picture, double share);

/// The overlay of these controls, through which the picture shines as they ask.
[[nodiscard]] Image<Rgb8> overlaid(const OverlayInput& input, const Controls& controls);

class Inspection {
 public:
  /// `renderer` has drawn a frame. Forgets the one before, and reads from this renderer from now on.
  void begin(Renderer& renderer);
  /// Inspects the last drawn frame, again if the controls have changed. `reference` may be null if
  /// needs_reference is false.
  void inspect(const FrameView& view, const Controls& controls, Reference* reference);

  /// What is known about a pixel of the inspected frame, which was drawn with a report. Waits for a copy of
  /// it. If the frame was measured, the surface is that of the reference, in full detail.
  [[nodiscard]] PixelFacts pixel(const FrameView& view, Side side, glm::uvec2 pixel) const;

  /// The errors of the frame, if it was measured.
  [[nodiscard]] const std::optional<PerEye<EyeErrors>>& errors() const { return errors_; }
  /// Pictures that replace those of the eyes; empty if the eyes are shown as drawn.
  [[nodiscard]] const std::optional<PerEye<Image<Rgb8>>>& replacement() const { return replacement_; }
  /// The pictures of the eyes, read back at the first call.
  [[nodiscard]] const PerEye<Image<Rgb8>>& shown();
  /// The displayed pictures: replacement() or shown().
  [[nodiscard]] const PerEye<Image<Rgb8>>& displayed() { return replacement_ ? *replacement_ : shown(); }

 private:
  [[nodiscard]] Image<Rgb8> overlaid(Side side, const FrameView& view, const Controls& controls) const;

  Renderer* renderer_ = nullptr;
  MeasuredFrame frame_;
  enum class Shown : std::uint8_t { NotRead, Read } read_ = Shown::NotRead;
  enum class Measured : std::uint8_t { No, Yes } measured_ = Measured::No;
  std::optional<PerEye<EyeErrors>> errors_;
  std::optional<PerEye<Image<Rgb8>>> replacement_;
};

}  // namespace farshade
