/// Pictures as files. Files are foreign bytes: sizes are checked before memory is taken, and a file that is
/// cut or damaged is refused as a whole. Colour profiles and gamma are ignored, as glTF asks (2.0
/// section 3.8.3).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "stereo/base/expected.h"
#include "stereo/image/image.h"

namespace farshade {

/// Limit of the read_ functions below: the largest view is 8192 x 8192.
inline constexpr std::uint64_t kMaxImagePixels = std::uint64_t{1} << 26;

/// PNG or JPEG, told apart by signature. 16 bits become 8, palettes and grey become colour, missing alpha is
/// 255. CMYK is Unsupported; more than `max_pixels` is OutOfRange.
[[nodiscard]] Expected<Image<Rgba8>> decode_image(std::span<const std::byte> file, std::uint64_t max_pixels);

/// 8-bit sRGB colour. Reading takes any PNG or JPEG and drops alpha.
[[nodiscard]] Expected<void> write_png(const std::filesystem::path& path, const Image<Rgb8>& image);
[[nodiscard]] Expected<Image<Rgb8>> read_png(const std::filesystem::path& path);

/// 16-bit grey, values as they are. Reading refuses any other PNG.
[[nodiscard]] Expected<void> write_png16(const std::filesystem::path& path,
                                         const Image<std::uint16_t>& image);
[[nodiscard]] Expected<Image<std::uint16_t>> read_png16(const std::filesystem::path& path);

/// One-channel PFM, little-endian, bottom row first. Any float travels, infinities and NaN too.
[[nodiscard]] Expected<void> write_pfm(const std::filesystem::path& path, const Image<float>& image);
[[nodiscard]] Expected<Image<float>> read_pfm(const std::filesystem::path& path);

}  // namespace farshade
