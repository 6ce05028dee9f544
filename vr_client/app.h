/// The client from options to files: opens what they name, runs the session, measures it, writes what was
/// seen.
#pragma once

#include "vr_client/options.h"

namespace farshade {

/// Prints progress to stderr and the summary to stdout. After a stop signal what was shown so far is written.
[[nodiscard]] Expected<void> run_client(const Options& options);

/// Shows the session of options.replay again and compares: prints the verdict and the summary, writes what
/// run_client writes. Anything that is not as recorded is a Mismatch, and so is another scene.
[[nodiscard]] Expected<void> run_replay(const Options& options);

/// Says what the scene needs and what is left out, in words.
[[nodiscard]] Expected<void> tell_plan(const Options& options);

/// Writes the recording in the format that the file name asks for.
[[nodiscard]] Expected<void> export_trace(const Options& options);

}  // namespace farshade
