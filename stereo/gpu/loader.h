/// The Vulkan loader of this machine.
#pragma once

#include <string>

namespace farshade::gpu {

/// The version of Vulkan that the loader supports, such as "1.3.239".
[[nodiscard]] std::string loader_version();

}  // namespace farshade::gpu
