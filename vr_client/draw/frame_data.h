/// What the shaders are told about a frame, composed in double and rounded once. Pure; no device needed.
#pragma once

#include <span>

#include "shaders/shared.h"
#include "stereo/frame/view.h"
#include "stereo/scene/scene_state.h"

namespace farshade {

[[nodiscard]] gpu::WindowData window_data(const View& view);
[[nodiscard]] gpu::EyeData eye_data(const View& view);

/// Where shown eye space lies in the views a mask was traced for. `place` is left to the caller.
[[nodiscard]] gpu::MaskData mask_data(const StereoView& shown, const StereoView& traced);

[[nodiscard]] gpu::InstanceData instance_data(const StereoView& shown,
                                              const Affine<Stage, Object>& stage_from_object);

[[nodiscard]] gpu::LightData light_data(const StereoView& shown, const Light& light);

/// False only if no part of the object-space box can be seen by `eye`.
[[nodiscard]] bool may_be_seen(const gpu::InstanceData& instance, std::size_t eye, const glm::vec3& low,
                               const glm::vec3& high);

}  // namespace farshade
