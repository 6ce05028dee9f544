/// Uploads: how shaders get what the host writes every frame.
#pragma once

#include <cstdint>

namespace farshade::gpu {

enum class Uploads : std::uint8_t {
  Direct,  ///< the host writes to the device's memory
  Staged,  ///< the host writes to its own memory, from which the device copies to its memory
};

}  // namespace farshade::gpu
