/// Reads the images that the programs write, for tests. Errors begin with the path.
#pragma once

#include <filesystem>

#include "stereo/base/expected.h"
#include "stereo/image/image.h"

namespace farshade {

/// Any PNG or JPEG, as 8-bit colour without alpha.
[[nodiscard]] Expected<Image<Rgb8>> read_png(const std::filesystem::path& path);
/// 16-bit grey, without any conversion. Refuses every other PNG.
[[nodiscard]] Expected<Image<std::uint16_t>> read_png16(const std::filesystem::path& path);
/// One-channel PFM, little-endian. Refuses every other PFM.
[[nodiscard]] Expected<Image<float>> read_pfm(const std::filesystem::path& path);

}  // namespace farshade
