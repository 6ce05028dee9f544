/// The codecs behind codec.h, on bytes in memory. Only one file includes each library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "stereo/base/expected.h"
#include "stereo/image/image.h"

namespace farshade {

[[nodiscard]] bool is_png(std::span<const std::byte> file);
[[nodiscard]] bool is_jpeg(std::span<const std::byte> file);
[[nodiscard]] bool is_webp(std::span<const std::byte> file);

[[nodiscard]] Expected<Image<Rgba8>> decode_png(std::span<const std::byte> file, std::uint64_t max_pixels);
[[nodiscard]] Expected<Image<Rgba8>> decode_jpeg(std::span<const std::byte> file, std::uint64_t max_pixels);
[[nodiscard]] Expected<Image<Rgba8>> decode_webp(std::span<const std::byte> file, std::uint64_t max_pixels);

[[nodiscard]] Expected<std::vector<std::byte>> encode_png(const Image<Rgb8>& image);
[[nodiscard]] Expected<std::vector<std::byte>> encode_png16(const Image<std::uint16_t>& image);

/// Refuses an empty picture, and a picture of more than `max_pixels`.
[[nodiscard]] Expected<void> check_size(std::uint32_t width, std::uint32_t height, std::uint64_t max_pixels);

}  // namespace farshade
