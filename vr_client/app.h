/// The client's runs. Each function opens what the options name and writes the reports.
#pragma once

#include "stereo/base/stop_signal.h"
#include "vr_client/openxr/headset_runtime.h"
#include "vr_client/options.h"

namespace farshade {

/// Shows the scene along a head recording. Prints progress to stderr and the summary to stdout. After a stop
/// signal it writes the reports of the frames so far, and returns Interrupted.
[[nodiscard]] Expected<void> run_client(const Options& options, StopSignal& stop);

/// Replays the capture options.replay and compares requests and pictures. Prints the verdict and the summary
/// and writes the same files as run_client. Returns Mismatch if the scene, a request or a picture differs,
/// and Interrupted after a stop signal.
[[nodiscard]] Expected<void> run_replay(const Options& options, StopSignal& stop);

/// Prints the plan: what the scene needs and what the programs leave out.
[[nodiscard]] Expected<void> print_plan(const Options& options);

/// Writes the head recording in the format that the extension of the file name selects.
[[nodiscard]] Expected<void> export_head_recording(const Options& options);

/// Shows the scene in a window. Mouse and keys or a head recording move the head. The viewer can change the
/// settings while it runs. A panel shows figures and settings.
///
/// Runs until the user closes the window, a stop signal comes (Fault::Interrupted) or the server refuses the
/// client. Then all recordings are finished, also if the device was lost. If the X server ends, Xlib ends the
/// program: a capture then lacks its last frame, and a head recording and a timeline are lost. If the server
/// does not answer, the preview continues and shows that.
[[nodiscard]] Expected<void> run_preview(const Options& options, StopSignal& stop);

/// Shows the scene in the headset until its runtime ends the session, options.frames were shown, or a stop
/// signal comes (Fault::Interrupted). With options.frames it writes the reports of run_client. Recordings are
/// finished also if the runtime fails, which is an error.
[[nodiscard]] Expected<void> run_headset(const Options& options, HeadsetSystem& system, StopSignal& stop);

}  // namespace farshade
