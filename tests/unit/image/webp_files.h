/// WebP files, made in memory by libwebp.
#pragma once

#include <cstddef>
#include <vector>

#include "stereo/image/image.h"

namespace farshade {

enum class WebpKind { Lossless, Lossy };
[[nodiscard]] std::vector<std::byte> make_webp(const Image<Rgba8>& image, WebpKind kind = WebpKind::Lossless);

/// Seeded noise with alpha from 128 on, lossless.
[[nodiscard]] std::vector<std::byte> make_noise_webp(Extent size);

}  // namespace farshade
