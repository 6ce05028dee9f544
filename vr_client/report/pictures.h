/// Pictures: the shown frames as PNG, and for the worst of them what was wrong and where each shadow came
/// from.
#pragma once

#include <filesystem>
#include <span>

#include "stereo/base/expected.h"
#include "vr_client/report/measure.h"
#include "vr_client/report/overlays.h"

namespace farshade {

/// One frame with its reference, kept to be written later.
struct MeasuredFrame {
  FrameId frame;
  PerEye<Image<Rgb8>> shown, reference;
  PerEye<ShownReport> report;  ///< empty where it was not shaded here
  MaskAges ages;
};

/// `frame_NNNN_left.png` and `_right.png`.
[[nodiscard]] Expected<void> write_shown(const std::filesystem::path& folder, FrameId frame,
                                         const PerEye<Image<Rgb8>>& shown);

/// `worst_NNNN_EYE_{shown,reference,difference_x8,source}.png`, the last where there is a report, and
/// `worst.png` with all of them: a row an eye.
[[nodiscard]] Expected<void> write_measured(const std::filesystem::path& folder, const MeasuredFrame& frame);

}  // namespace farshade
