/// What the shaders are told about a frame, composed in double and rounded once. Pure; no device needed.
#pragma once

#include <span>

#include "shaders/shared.h"
#include "stereo/frame/pose_delta.h"
#include "stereo/scene/scene_state.h"

namespace farshade {

[[nodiscard]] gpu::WindowData window_data(const View& view);
[[nodiscard]] gpu::EyeData eye_data(const View& view);

/// How a shown eye looks points up in a traced view. `place` is left to the caller.
[[nodiscard]] gpu::SourceData source_data(const PoseDelta& delta, const View& traced);

/// Pixels of `traced` that lie left of and above `shown`'s, if both have one pixel grid: the guard band.
/// The nearest whole number if they have not.
[[nodiscard]] glm::ivec2 grid_offset_px(const View& shown, const View& traced);

/// xy, zw: a pixel position p of `shown` lies at p * xy + zw in `traced`, were both of one pose.
[[nodiscard]] glm::vec4 pixel_map(const View& shown, const View& traced);

/// Whether a shown pixel's centre is a traced pixel's centre: one pose, one pixel grid.
[[nodiscard]] bool shares_pixels(const View& shown, const View& traced);

[[nodiscard]] gpu::InstanceData instance_data(const StereoView& shown,
                                              const Affine<Stage, Object>& stage_from_object);

/// A light that is off shines with intensity 0.
[[nodiscard]] gpu::LightData light_data(const StereoView& shown, const Light& light);

/// False only if no part of the object-space box can be seen by `eye`.
[[nodiscard]] bool may_be_seen(const gpu::InstanceData& instance, std::size_t eye, const glm::vec3& low,
                               const glm::vec3& high);

}  // namespace farshade
