/// The client's runs without a window. Each function opens what the options name and writes the reports.
#pragma once

#include "vr_client/options.h"

namespace farshade {

/// Shows the scene along a head recording. Prints progress to stderr and the summary to stdout. After a stop
/// signal it writes the reports of the frames so far.
[[nodiscard]] Expected<void> run_client(const Options& options);

/// Replays the capture options.replay and compares requests and pictures. Prints the verdict and the summary
/// and writes the same files as run_client. Returns Mismatch if the scene, a request or a picture differs.
[[nodiscard]] Expected<void> run_replay(const Options& options);

/// Prints the plan: what the scene needs and what the programs leave out.
[[nodiscard]] Expected<void> print_plan(const Options& options);

/// Writes the head recording in the format that the extension of the file name selects.
[[nodiscard]] Expected<void> export_head_recording(const Options& options);

}  // namespace farshade
