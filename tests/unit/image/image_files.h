/// PNG and JPEG files of every kind that a scene may contain, made in memory by the libraries' own writers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "stereo/base/extent.h"

namespace farshade {

/// A PNG whose packed rows are `rows`, one after the other (pixels beyond them are 0). A palette is red,
/// green with alpha 128, blue, white.
[[nodiscard]] std::vector<std::byte> make_png(Extent size, int bits, int color,
                                              const std::vector<std::uint8_t>& rows);

/// An interlaced 8-bit RGBA PNG of seeded noise.
[[nodiscard]] std::vector<std::byte> make_noise_png(Extent size);

/// Grey 1x1 PNGs of value 77: one with a compressed text that cannot be decompressed, one with a row too
/// many.
[[nodiscard]] std::vector<std::byte> make_png_with_faulty_text();
[[nodiscard]] std::vector<std::byte> make_png_with_extra_row();

enum class JpegKind { Colour, Grey, Cmyk, Progressive, ManyScans };

/// A JPEG of one colour: (200, 100, 50), or grey 200.
[[nodiscard]] std::vector<std::byte> make_jpeg(Extent size, JpegKind kind);

}  // namespace farshade
