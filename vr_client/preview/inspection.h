/// Inspection: a shown frame, looked into as the controls ask: measured against its reference, and its eyes
/// replaced by overlays or by what is wrong with them. Costs nothing while nothing is asked.
#pragma once

#include "vr_client/preview/controls.h"
#include "vr_client/report/measured_frame.h"

namespace farshade {

/// Whether these controls need the full trace of what is shown.
[[nodiscard]] bool needs_reference(const Controls& controls);

class Inspection {
 public:
  /// Reads `renderer`'s pictures.
  explicit Inspection(Renderer& renderer) : renderer_(renderer) {}

  /// Of the frame drawn last. `reference` may be null where needs_reference is false.
  void look(const FrameView& view, const Controls& controls, Reference* reference);

  /// How wrong the frame is, if it was measured.
  [[nodiscard]] const std::optional<PerEye<EyeErrors>>& errors() const { return errors_; }
  /// To be shown in place of the eyes as drawn; nothing: the eyes as drawn.
  [[nodiscard]] const std::optional<PerEye<Image<Rgb8>>>& in_place() const { return in_place_; }
  /// The eyes as drawn; read back when first asked for.
  [[nodiscard]] const PerEye<Image<Rgb8>>& shown();
  /// What is on show: in_place() or shown().
  [[nodiscard]] const PerEye<Image<Rgb8>>& on_show() { return in_place_ ? *in_place_ : shown(); }

 private:
  [[nodiscard]] Image<Rgb8> overlaid(Side side, const FrameView& view, const Controls& controls) const;

  Renderer& renderer_;
  MeasuredFrame frame_;
  enum class Shown : std::uint8_t { NotRead, Read } read_ = Shown::NotRead;
  enum class Measured : std::uint8_t { No, Yes } measured_ = Measured::No;
  std::optional<PerEye<EyeErrors>> errors_;
  std::optional<PerEye<Image<Rgb8>>> in_place_;
};

}  // namespace farshade
