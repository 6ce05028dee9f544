/// How many instances a scene that is drawn may have.
#pragma once

#include <cstddef>

namespace farshade {

/// A renderer draws scenes of at most this many instances: the G-buffer stores an instance in 16 bits.
inline constexpr std::size_t kMaxInstances = 1 << 16;

}  // namespace farshade
