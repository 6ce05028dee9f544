/// EyeMask: for each pixel one bit per light of the light set, 1 = the light is visible from the pixel's
/// surface point.
///
/// A pixel's bits are stored in the smallest word that holds them (1, 2 or 4 bytes for up to 8, 16 or 32
/// lights). More than 32 lights need several planes of 4-byte words: light i is bit i % 32 of plane i / 32. A
/// plane is row-major, top row first, without padding. Pixels without a surface are 0.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "stereo/base/extent.h"

namespace farshade {

inline constexpr std::uint32_t kMaxLights = 256;

/// Lights: light i is bit i % 32 of word i / 32.
using LightBits = std::array<std::uint32_t, kMaxLights / 32>;

/// The memory layout of masks of `lights` lights. Tracer, wire and shaders share it.
struct MaskLayout {
  std::uint32_t lights = 0;
  std::uint32_t least_word_bytes = 1;  ///< 1, 2 or 4: minimum size of a word

  [[nodiscard]] constexpr std::uint32_t planes() const { return lights == 0 ? 1 : (lights + 31) / 32; }
  [[nodiscard]] constexpr std::uint32_t word_bytes() const {
    const std::uint32_t needed = lights <= 8 ? 1 : lights <= 16 ? 2 : 4;
    return needed > least_word_bytes ? needed : least_word_bytes;
  }
  /// Number of lights in plane `plane`. Higher bits of its words are 0.
  [[nodiscard]] constexpr std::uint32_t lights_in(std::uint32_t plane) const {
    const std::uint32_t before = plane * 32;
    return lights <= before ? 0 : lights - before < 32 ? lights - before : 32;
  }
  [[nodiscard]] constexpr std::uint32_t used_bits(std::uint32_t plane) const {
    const std::uint32_t n = lights_in(plane);
    return n == 32 ? ~0u : (1u << n) - 1;
  }
  friend bool operator==(MaskLayout, MaskLayout) = default;
};

class EyeMask {
 public:
  EyeMask() = default;
  /// All bits 0. `lights` is at most kMaxLights.
  EyeMask(Extent size, std::uint32_t lights) : EyeMask(size, MaskLayout{.lights = lights}) {}
  EyeMask(Extent size, MaskLayout layout);

  [[nodiscard]] Extent size() const { return size_; }
  [[nodiscard]] std::uint32_t lights() const { return layout_.lights; }
  [[nodiscard]] MaskLayout layout() const { return layout_; }

  [[nodiscard]] std::uint32_t word(std::uint32_t x, std::uint32_t y, std::uint32_t plane = 0) const;
  /// `bits` must have no bit above lights_in(plane).
  void set_word(std::uint32_t x, std::uint32_t y, std::uint32_t plane, std::uint32_t bits);
  [[nodiscard]] bool lit(std::uint32_t x, std::uint32_t y, std::uint32_t light) const {
    return (word(x, y, light / 32) >> (light % 32) & 1u) != 0;
  }

  /// planes x height x width x word_bytes bytes, words in the machine's byte order.
  [[nodiscard]] std::span<std::byte> bytes() { return bytes_; }
  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }

  friend bool operator==(const EyeMask&, const EyeMask&) = default;

 private:
  [[nodiscard]] std::size_t offset(std::uint32_t x, std::uint32_t y, std::uint32_t plane) const {
    return ((plane * size_.pixels()) + std::size_t{y} * size_.width + x) * layout_.word_bytes();
  }

  Extent size_;
  MaskLayout layout_;
  std::vector<std::byte> bytes_;
};

}  // namespace farshade
