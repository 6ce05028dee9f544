/// Preview: the client with a window. Mouse and keys or a head recording move the head. The viewer can change
/// the settings while it runs. A panel shows figures and settings.
#pragma once

#include "vr_client/options.h"

namespace farshade {

/// Runs until the user closes the window, a stop signal comes or the server refuses the client. Then all
/// recordings are finished, also if the device was lost. If the X server ends, Xlib ends the program: a
/// capture then lacks its last frame, and a head recording and a timeline are lost. If the server does not
/// answer, the preview continues and shows that.
[[nodiscard]] Expected<void> run_preview(const Options& options);

}  // namespace farshade
