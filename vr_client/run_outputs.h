/// RunOutputs: what a run of the client writes while it shows frames, and at its end: the capture, the
/// timeline, figures and pictures. Notices when the server is silent, which no figure includes.
#pragma once

#include "vr_client/client.h"
#include "vr_client/record/capture_writer.h"
#include "vr_client/report/run_report.h"
#include "vr_client/report/silence.h"
#include "vr_client/report/timeline.h"

namespace farshade {

[[nodiscard]] RunReportOptions report_options(const Options& options, std::uint32_t frames, Compare compare);

/// On if the run measures frames, for which every frame reports.
[[nodiscard]] PixelReport report_of(const Options& options);

class RunOutputs {
 public:
  /// Makes the output folder, without the files of an earlier run. Unavailable if the capture exists already.
  [[nodiscard]] static Expected<void> prepare(const Options& options);

  /// Without `measuring` the run has no figures and no pictures. Keeps the references; the client has a
  /// renderer, and a reference if frames are measured.
  RunOutputs(const Options& options, Client& client, Stages& stages,
             std::optional<RunReportOptions> measuring);

  [[nodiscard]] bool captures() const { return !options_.record.empty(); }
  /// For the link. It does nothing if the run is not captured.
  [[nodiscard]] LinkListener listener() { return captures() ? capture_.listener() : LinkListener{}; }
  /// Creates the capture, if the options name one. Call it before the first frame is added. `shown`: the
  /// options with the refresh rate of the display.
  [[nodiscard]] Expected<void> open_capture(const Options& shown);

  /// Call it when the link is open. Writes empty files, so that a path that cannot be written fails early.
  [[nodiscard]] Expected<void> begin();

  /// The client has lost its device. A capture ends, because a replay loses none.
  void lose_device();

  /// Adds a frame that was shown. Returns what to tell the user.
  [[nodiscard]] std::optional<std::string> watch(const FrameView& view);

  /// Writes everything. `summarize` is called once the figures are complete,
  /// if the run has figures. Returns the first failure.
  [[nodiscard]] Expected<void> finish(bool was_interrupted, const std::function<Expected<void>()>& summarize);

  [[nodiscard]] std::uint32_t frames() const { return frames_; }  ///< shown
  [[nodiscard]] const FrameLog* log() const { return report_ ? &report_->log() : nullptr; }
  [[nodiscard]] const Silence& silence() const { return silence_; }
  [[nodiscard]] const CaptureWriter& capture() const { return capture_; }

 private:
  [[nodiscard]] Expected<void> compare_kept();

  const Options& options_;
  Client& client_;
  Stages& stages_;
  CaptureWriter capture_;
  Timeline timeline_;
  std::optional<RunReport> report_;
  Silence silence_{{}};
  std::uint32_t frames_ = 0;
};

}  // namespace farshade
