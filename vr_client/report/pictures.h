/// PNG pictures of shown frames. For the worst frame also the differences and the source of each shadow.
#pragma once

#include <filesystem>
#include <span>

#include "stereo/base/expected.h"
#include "vr_client/report/measure.h"

namespace farshade {

/// `frame_NNNN_left.png` and `_right.png`.
[[nodiscard]] Expected<void> write_shown(const std::filesystem::path& folder, FrameId frame,
                                         const PerEye<Image<Rgb8>>& shown);

/// `worst_NNNN_EYE_{shown,reference,difference_x8,source}.png`, and `worst.png` with all of them in one row
/// per eye. The source picture needs a report.
[[nodiscard]] Expected<void> write_measured(const std::filesystem::path& folder, const MeasuredFrame& frame);

}  // namespace farshade
