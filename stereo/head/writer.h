/// Writes head recordings. In both formats, a written recording reads back bit for bit.
#pragma once

#include <filesystem>
#include <string>

#include "stereo/base/expected.h"
#include "stereo/head/head_recording.h"

namespace farshade {

/// EuRoC/ASL CSV, `ns,x,y,z,qw,qx,qy,qz`, after lines that state axes, units, clock, space, eye distance and
/// fov.
[[nodiscard]] std::string euroc_text(const HeadRecording& recording);
/// TUM, `seconds x y z qx qy qz qw`, after the same lines as comments.
[[nodiscard]] std::string tum_text(const HeadRecording& recording);

/// Atomic: on failure `path` stays unchanged.
[[nodiscard]] Expected<void> write_euroc(const std::filesystem::path& path, const HeadRecording& recording);
[[nodiscard]] Expected<void> write_tum(const std::filesystem::path& path, const HeadRecording& recording);

}  // namespace farshade
