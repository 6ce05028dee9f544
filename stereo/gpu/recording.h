/// Recording: commands that somebody adds to a frame. Headers of programs include this file; it does not
/// include Vulkan's headers.
#pragma once

#include <functional>

namespace vk::raii {
class CommandBuffer;
}  // namespace vk::raii

namespace farshade::gpu {

/// Records commands.
using Recording = std::function<void(const vk::raii::CommandBuffer&)>;

/// Takes a recording into the frame that is recorded now, and calls it at once.
using Recorder = std::function<void(const Recording&)>;

}  // namespace farshade::gpu
