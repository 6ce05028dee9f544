/// Reads and writes image files. Decoders check sizes before they allocate, and refuse a truncated or damaged
/// file as a whole. They ignore colour profiles and gamma, as glTF 2.0 requires (section 3.8.3).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "stereo/base/expected.h"
#include "stereo/image/image.h"

namespace farshade {

/// Limit of the read_ functions below: the pixels of the largest view, 8192 x 8192.
inline constexpr std::uint64_t kMaxImagePixels = std::uint64_t{1} << 26;

/// Decodes PNG or JPEG, depending on the signature. Converts 16 bits to 8, and palettes and grey to colour.
/// Missing alpha is 255. Errors: Unsupported for CMYK, OutOfRange for more than `max_pixels`.
[[nodiscard]] Expected<Image<Rgba8>> decode_image(std::span<const std::byte> file, std::uint64_t max_pixels);

/// 8-bit sRGB colour. read_png accepts any PNG or JPEG and drops alpha.
[[nodiscard]] Expected<void> write_png(const std::filesystem::path& path, const Image<Rgb8>& image);
[[nodiscard]] Expected<Image<Rgb8>> read_png(const std::filesystem::path& path);

/// 16-bit grey, without any conversion. read_png16 refuses every other PNG.
[[nodiscard]] Expected<void> write_png16(const std::filesystem::path& path,
                                         const Image<std::uint16_t>& image);
[[nodiscard]] Expected<Image<std::uint16_t>> read_png16(const std::filesystem::path& path);

/// One-channel PFM, little-endian, bottom row first. Keeps every float, also infinities and NaN.
[[nodiscard]] Expected<void> write_pfm(const std::filesystem::path& path, const Image<float>& image);
[[nodiscard]] Expected<Image<float>> read_pfm(const std::filesystem::path& path);

}  // namespace farshade
