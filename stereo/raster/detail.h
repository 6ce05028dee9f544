/// Detail: whether a frame is drawn with levels of detail.
#pragma once

#include <cstdint>

namespace farshade {

/// Which geometry a frame draws.
enum class Detail : std::uint8_t {
  Levels,  ///< each instance at the coarsest level whose error is below the plan's limit
  Full,    ///< every mesh as it is
};

}  // namespace farshade
