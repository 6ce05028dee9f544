/// Preview: the client behind a window. Hands or a recording move the head, controls steer the session frame
/// by frame, and what is shown is composed into the window with a panel that says how it came about.
#pragma once

#include "vr_client/options.h"

namespace farshade {

/// Until the window is closed, a signal comes or the server refuses us for good. What was being recorded is
/// then finished, also if the device is lost; not if the X server goes, with which Xlib ends the program: a
/// session file then lacks its last frame, a head and a timeline are lost. A server that is not there or goes
/// away is shown, not an end.
[[nodiscard]] Expected<void> run_preview(const Options& options);

}  // namespace farshade
