/// Summarize: prints how a run went, and writes the summary that --json asks for.
#pragma once

#include <cstdio>
#include <string>

#include "stereo/placement/head_test.h"
#include "vr_client/client.h"
#include "vr_client/report/frame_log.h"
#include "vr_client/report/silence.h"

namespace farshade {

/// "12.3 MB".
[[nodiscard]] std::string megabytes(std::uint64_t bytes);

/// Null if the mode draws no shadow maps.
[[nodiscard]] const ShadowMapSettings* maps_of(const Options& options);

/// Where text for people goes: with --json - the standard output carries the JSON alone.
[[nodiscard]] std::FILE* readable_output(const Options& options);

struct FinishedRun {
  const FrameLog& log;
  const Silence& silence;
  std::uint64_t missed = 0;  ///< display times
  bool interrupted = false;
  HeadTest head_test{};
  std::string head{};  ///< what moved the head; empty: the head recording of the options
};
/// Prints the verdict and the figures that matter in the mode, and writes the file of --json.
[[nodiscard]] Expected<void> summarize(const Options& options, const Client& client, const FinishedRun& run);

struct FinishedReplay {
  const FrameLog& log;
  const CaptureHeader& header;
  Mode mode{};
  std::string verdict;  ///< of the comparison with the captured run
  bool interrupted = false;
};
[[nodiscard]] Expected<void> summarize(const Options& options, const Client& client,
                                       const FinishedReplay& replay);

/// Missing if the mode needs a server and no answer of it ever came.
[[nodiscard]] Expected<void> check_answered(const Client& client, const FrameLog& log);

}  // namespace farshade
