/// The data of a frame for the shaders, computed in double and rounded to float once. Pure; no device needed.
#pragma once

#include "shaders/shared.h"
#include "stereo/frame/pose_delta.h"
#include "stereo/scene/scene_state.h"

namespace farshade {

[[nodiscard]] gpu::WindowData window_data(const View& view);
[[nodiscard]] gpu::EyeData eye_data(const View& view);

/// How a shown eye's points are projected into a traced view. The caller fills `place`.
[[nodiscard]] gpu::SourceData source_data(const PoseDelta& delta, const View& traced);

/// The number of pixels of `traced` to the left of and above `shown` (its guard band), if both have one pixel
/// grid. Otherwise rounded to whole pixels.
[[nodiscard]] glm::ivec2 grid_offset_px(const View& shown, const View& traced);

/// (xy, zw): a pixel position p of `shown` is at p * xy + zw in `traced`, as if both had one pose.
[[nodiscard]] glm::vec4 pixel_map(const View& shown, const View& traced);

/// Whether each shown pixel's centre is a traced pixel's centre: same pose, same pixel grid.
[[nodiscard]] bool shares_pixels(const View& shown, const View& traced);

[[nodiscard]] gpu::InstanceData instance_data(const StereoView& shown,
                                              const Affine<Stage, Object>& stage_from_object);

/// A light that is off has intensity 0.
[[nodiscard]] gpu::LightData light_data(const StereoView& shown, const Light& light,
                                        const Exposure& exposure = {});

/// A conservative frustum test: false only if `eye` can see no part of the object-space box.
[[nodiscard]] bool may_be_seen(const gpu::InstanceData& instance, std::size_t eye, const Bounds& box);

}  // namespace farshade
