/// The eye that a dispatch of shade.comp or request_reprojection.comp is for: a push constant, so that one
/// pipeline serves both eyes.
#pragma once

#include "stereo/gpu/pass.h"

namespace farshade {

inline constexpr vk::PushConstantRange kShownEye =
    gpu::push_constants<std::uint32_t>(vk::ShaderStageFlagBits::eCompute);

inline void push_shown_eye(const vk::raii::CommandBuffer& commands, const vk::raii::PipelineLayout& layout,
                           std::uint32_t eye) {
  commands.pushConstants<std::uint32_t>(*layout, kShownEye.stageFlags, kShownEye.offset, eye);
}

}  // namespace farshade
