/// Writes head traces. Reading back what was written gives the same trace, bit for bit, in either format.
#pragma once

#include <filesystem>
#include <string>

#include "stereo/base/expected.h"
#include "stereo/head/head_recording.h"

namespace farshade {

/// EuRoC/ASL CSV, `ns,x,y,z,qw,qx,qy,qz`, under lines that state axes, units, clock, space, eye distance and
/// fov.
[[nodiscard]] std::string euroc_text(const HeadRecording& trace);
/// TUM, `seconds x y z qx qy qz qw`, under the same lines as comments.
[[nodiscard]] std::string tum_text(const HeadRecording& trace);

/// Atomic: on failure `path` is as it was.
[[nodiscard]] Expected<void> write_euroc(const std::filesystem::path& path, const HeadRecording& trace);
[[nodiscard]] Expected<void> write_tum(const std::filesystem::path& path, const HeadRecording& trace);

}  // namespace farshade
