/// Measure: errors of a shown frame, compared with a full trace at the shown pose.
#pragma once

#include <limits>
#include <optional>

#include "stereo/frame/pose_delta.h"
#include "vr_client/frame/frame_loop.h"
#include "vr_client/report/overlays.h"

namespace farshade {

inline constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

/// Errors of one eye of one frame. Shares and errors are means over covered pixels x lights. The shares
/// newest, other_eye, older, cube mask, neighbours, own_rays and unknown add up to 1. If the mode shows a
/// picture from the server, single lights cannot be distinguished, and all values but those of whole pictures
/// are kNotMeasured. If an eye shows no surface, they are 0, and the log leaves them out.
struct EyeErrors {
  double mask_error = 0;   ///< mean of |shown visibility - reference visibility|
  double known_error = 0;  ///< the same over pixel-lights that are not unknown
  double psnr_db = 0;      ///< of the shown sRGB picture; 99 if it equals the reference
  double newest = 0;       ///< share taken from this eye's newest mask
  double other_eye = 0;    ///< from the other eye's newest mask
  double older = 0;        ///< from older masks of either eye
  double cube_mask = 0;    ///< from the cube mask
  double neighbours = 0;   ///< from the nearest pixel on the same surface
  double own_rays = 0;     ///< of points that the newest mask does not know, decided by the client's own rays
  double unknown = 0;      ///< share without a known visibility
  double stale = 0;        ///< share of all that is known but outdated, because something has moved since
  std::optional<double> unmoved_error;  ///< mask error of the newest mask if it is not reprojected
  /// Share of the eye's pixels that show a surface: of these, all others are shares.
  double covered = kNotMeasured;
  /// Share of the eye's pixels in which the rasteriser, in full detail, and the reference tracer's own rays
  /// see another surface (other_surface_share).
  double other_surface = kNotMeasured;
  double flip = kNotMeasured, ssim = kNotMeasured;  ///< of the shown picture, against the reference
};

/// The share of pixels that only one of both covers, or in which the distances differ by more than 1 %.
[[nodiscard]] double other_surface_share(const Image<float>& drawn_m, const Image<float>& traced_m);

/// Compares `shown`, the report of the shading pass, with `reference`, which was traced for the same view.
/// The caller sets psnr_db and unmoved_error.
[[nodiscard]] EyeErrors compare_masks(const ShownReport& shown, const EyeMask& reference);

/// Mask error of `stale` without reprojection, over the covered pixels of `shown`. Shown pixel p reads pixel
/// p + offset_px of `stale`. Pixels outside of `stale` count as unknown, with visibility kUnknownVisibility.
[[nodiscard]] double unmoved_error(const EyeMask& stale, glm::ivec2 offset_px, const ShownReport& shown,
                                   const EyeMask& reference);

/// One frame with its reference.
struct MeasuredFrame {
  FrameId frame;
  PerEye<Image<Rgb8>> shown, reference;
  PerEye<Image<float>> flip{};  ///< of each pixel of `shown`, against `reference`
  PerEye<ShownReport> report;   ///< empty if the client did not shade the frame
  MaskAges ages;
};

/// Upper limit of the PSNR. Equal pictures have an infinite one, which has no percentiles.
inline constexpr double kEqualPictures_dB = 99;

/// The cost of the guard band: requested pixels beyond the shown ones, as a share of the shown ones. Empty if
/// the frame had no request.
[[nodiscard]] std::optional<double> guard_band_of(const FrameView& view);

/// The time since the request of each mask that `view` was drawn with, by mask_of(source).
[[nodiscard]] MaskAges ages_of(const FrameView& view);

/// A shown frame, with all that a comparison needs, so that it can be compared later.
struct FrameToMeasure {
  FrameMoment shown;
  SceneState state;
  ShownAs as = ShownAs::Shaded;
  MaskAges ages{};
  PerEye<Image<Rgb8>> pictures{};
  PerEye<ShownReport> report{};  ///< empty if the client did not shade the frame
  StereoView traced{};           ///< the views of the newest mask
  PerEye<EyeMask> newest{};      ///< the newest mask; empty without one

  [[nodiscard]] std::uint64_t bytes() const;  ///< of pictures, report and mask
};

/// Call it before the next frame is drawn. The frame must have been drawn with PixelReport::On.
[[nodiscard]] FrameToMeasure read_back(const FrameView& view, Renderer& renderer);

/// The picture of `traced`, which was traced for the views of `shown`, in full detail.
[[nodiscard]] PerEye<Image<Rgb8>> draw_traced(const FrameMoment& shown, const SceneState& state,
                                              const TracedMask& traced, Renderer& renderer);

/// Stores the shown frame and its reference in `into` and returns the errors. Afterwards the renderer holds
/// the reference's picture.
[[nodiscard]] PerEye<EyeErrors> measure(FrameToMeasure frame, Renderer& renderer, Reference& reference,
                                        MeasuredFrame& into);

/// The same for a frame that was just drawn.
[[nodiscard]] PerEye<EyeErrors> measure(const FrameView& view, Renderer& renderer, Reference& reference,
                                        MeasuredFrame& into);

}  // namespace farshade
