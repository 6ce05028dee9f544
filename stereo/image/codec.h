/// Decodes images and writes image files. Decoders check sizes before they allocate, and refuse a truncated
/// or damaged file as a whole. They ignore colour profiles and gamma, as glTF 2.0 requires (section 3.8.3).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "stereo/base/expected.h"
#include "stereo/image/image.h"

namespace farshade {

/// Decodes PNG, JPEG or WebP, depending on the signature. Converts 16 bits to 8, and palettes and grey to
/// colour. Missing alpha is 255. Errors: Unsupported for CMYK and animations, OutOfRange for more than
/// `max_pixels`.
[[nodiscard]] Expected<Image<Rgba8>> decode_image(std::span<const std::byte> file, std::uint64_t max_pixels);

/// 8-bit sRGB colour.
[[nodiscard]] Expected<void> write_png(const std::filesystem::path& path, const Image<Rgb8>& image);

/// 16-bit grey, without any conversion.
[[nodiscard]] Expected<void> write_png16(const std::filesystem::path& path,
                                         const Image<std::uint16_t>& image);

/// One-channel PFM, little-endian, bottom row first. Keeps every float, also infinities and NaN.
[[nodiscard]] Expected<void> write_pfm(const std::filesystem::path& path, const Image<float>& image);

}  // namespace farshade
