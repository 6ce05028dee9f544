/// Test expectation: the tracer agrees with the oracle.
#pragma once

#include "stereo/tracer/tracer.h"
#include "tests/oracle/oracle.h"

namespace farshade {

[[nodiscard]] FrameRequest request_for(const StereoView& views, Time scene_time = {}, FrameId frame = {});

/// The masks of `views` at `scene_time`, by the tracer.
[[nodiscard]] ShadowFrame traced(const Scene& scene, const StereoView& views, Time scene_time = {});

/// The same by a tracer that skips no ray: a reference for other masks.
[[nodiscard]] ShadowFrame reference_traced(const Scene& scene, const StereoView& views, Time scene_time = {});

/// The same view for both eyes.
[[nodiscard]] ShadowFrame traced(const Scene& scene, const View& view, Time scene_time = {});

/// Expects that the tracer's masks of both views equal the oracle's outside the band, that the band is at
/// most the share `most_in_band` of all pixel-lights, and that at most a tenth of the band differs. Returns
/// the sums over both eyes.
oracle::Agreement expect_agrees(const Scene& scene, const StereoView& views, Time scene_time,
                                double most_in_band);

}  // namespace farshade
