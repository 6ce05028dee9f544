/// MeasuredFrame: a frame just shown, read back, traced in full at the very pose shown, and compared.
#pragma once

#include "vr_client/frame/frame_loop.h"
#include "vr_client/report/pictures.h"

namespace farshade {

/// Equal pictures have an infinite PSNR, of which no percentile can be taken.
inline constexpr double kEqualPictures_dB = 99;

/// How long ago each mask that `view` was drawn with was asked for, newest first.
[[nodiscard]] MaskAges ages_of(const FrameView& view);

/// Leaves `into` holding the frame as shown and as it should have been. Call it before the next frame is
/// drawn; the frame was drawn with Report::On. Of one that was not shaded here there is no report. Afterwards
/// the renderer's picture is the reference's.
[[nodiscard]] PerEye<EyeErrors> measure(const FrameView& view, Renderer& renderer, Reference& reference,
                                        MeasuredFrame& into);

}  // namespace farshade
