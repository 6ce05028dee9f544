#include "stereo/frame/eye_mask.h"

#include <cstring>

#include "stereo/base/check.h"

namespace farshade {

EyeMask::EyeMask(Extent size, MaskLayout layout) : size_(size), layout_(layout) {
  check(layout.lights <= kMaxLights, "a mask has at most kMaxLights lights");
  bytes_.resize(size.pixels() * layout_.planes() * layout_.word_bytes());
}

std::uint32_t EyeMask::word(std::uint32_t x, std::uint32_t y, std::uint32_t plane) const {
  const std::byte* at = bytes_.data() + offset(x, y, plane);
  switch (layout_.word_bytes()) {
    case 1:
      return std::to_integer<std::uint32_t>(*at);
    case 2: {
      std::uint16_t bits;
      std::memcpy(&bits, at, sizeof bits);
      return bits;
    }
    default: {
      std::uint32_t bits;
      std::memcpy(&bits, at, sizeof bits);
      return bits;
    }
  }
}

void EyeMask::set_word(std::uint32_t x, std::uint32_t y, std::uint32_t plane, std::uint32_t bits) {
  std::byte* at = bytes_.data() + offset(x, y, plane);
  switch (layout_.word_bytes()) {
    case 1:
      *at = static_cast<std::byte>(bits);
      break;
    case 2: {
      const auto narrow_bits = static_cast<std::uint16_t>(bits);
      std::memcpy(at, &narrow_bits, sizeof narrow_bits);
      break;
    }
    default:
      std::memcpy(at, &bits, sizeof bits);
  }
}

}  // namespace farshade
