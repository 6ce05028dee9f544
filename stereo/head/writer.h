/// Head recordings as text. In both formats, the text reads back bit for bit.
#pragma once

#include <string>

#include "stereo/head/head_recording.h"

namespace farshade {

/// EuRoC/ASL CSV, `ns,x,y,z,qw,qx,qy,qz`, after lines that state axes, units, clock, space, eye distance and
/// fov.
[[nodiscard]] std::string euroc_text(const HeadRecording& recording);
/// TUM, `seconds x y z qx qy qz qw`, after the same lines as comments.
[[nodiscard]] std::string tum_text(const HeadRecording& recording);

}  // namespace farshade
