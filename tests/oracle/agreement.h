/// Test expectation: the tracer agrees with the oracle.
#pragma once

#include "stereo/tracer/tracer.h"
#include "tests/oracle/oracle.h"

namespace farshade {

[[nodiscard]] FrameRequest request_for(const StereoView& views, Time scene_time = {}, FrameId frame = {});

/// Traces `views` at `scene_time`.
[[nodiscard]] ShadowFrame traced(const Scene& scene, const StereoView& views, Time scene_time = {});

/// The same by a tracer without proofs: for masks that others are compared with.
[[nodiscard]] ShadowFrame reference_traced(const Scene& scene, const StereoView& views, Time scene_time = {});

/// The same view for both eyes.
[[nodiscard]] ShadowFrame traced(const Scene& scene, const View& view, Time scene_time = {});

/// Expects the tracer's masks of both views to equal the oracle's outside the band, the band to hold at most
/// `most_in_band` of the pixel-lights, and at most a tenth of the band to differ. Returns both eyes' sums.
oracle::Agreement expect_agrees(const Scene& scene, const StereoView& views, Time scene_time,
                                double most_in_band);

}  // namespace farshade
