/// Measuring a shown frame: read it back, trace it in full at the shown pose, and compare.
#pragma once

#include "vr_client/frame/frame_loop.h"
#include "vr_client/report/pictures.h"

namespace farshade {

/// Upper limit of the PSNR. Equal pictures have an infinite one, which has no percentiles.
inline constexpr double kEqualPictures_dB = 99;

/// The time since the request of each mask that `view` was drawn with, newest mask first.
[[nodiscard]] MaskAges ages_of(const FrameView& view);

/// Stores the shown frame and its reference in `into` and returns the errors. Call it before the next frame
/// is drawn. The frame must have been drawn with Report::On. A frame that was not shaded by this client has
/// no report. Afterwards the renderer holds the reference's picture.
[[nodiscard]] PerEye<EyeErrors> measure(const FrameView& view, Renderer& renderer, Reference& reference,
                                        MeasuredFrame& into);

}  // namespace farshade
