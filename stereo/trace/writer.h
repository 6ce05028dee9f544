/// Writes head traces. Reading back what was written gives the same trace, bit for bit, in either format.
#pragma once

#include <filesystem>
#include <string>

#include "stereo/base/expected.h"
#include "stereo/trace/head_trace.h"

namespace farshade {

/// EuRoC/ASL CSV, `ns,x,y,z,qw,qx,qy,qz`, under lines that state axes, units, clock, space, eye distance and
/// fov.
[[nodiscard]] std::string euroc_text(const HeadTrace& trace);
/// TUM, `seconds x y z qx qy qz qw`, under the same lines as comments.
[[nodiscard]] std::string tum_text(const HeadTrace& trace);

/// Atomic: on failure `path` is as it was.
[[nodiscard]] Expected<void> write_euroc(const std::filesystem::path& path, const HeadTrace& trace);
[[nodiscard]] Expected<void> write_tum(const std::filesystem::path& path, const HeadTrace& trace);

}  // namespace farshade
