/// The size of a picture in pixels.
#pragma once

#include <cstddef>
#include <cstdint>

namespace farshade {

struct Extent {
  std::uint32_t width = 0, height = 0;  ///< pixels
  friend bool operator==(Extent, Extent) = default;
  [[nodiscard]] constexpr std::size_t pixels() const { return std::size_t{width} * height; }
};

}  // namespace farshade
