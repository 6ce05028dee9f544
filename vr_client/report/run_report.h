/// Recorder: watches the session, measures its frames and writes pictures of them as they come.
#pragma once

#include <filesystem>
#include <optional>

#include "vr_client/frame/frame_loop.h"
#include "vr_client/report/frame_log.h"
#include "vr_client/report/pictures.h"

namespace farshade {

struct RunReportOptions {
  std::filesystem::path out;
  std::uint32_t frame_count = 0;      ///< that the session will show, to spread pictures and tell progress
  std::uint32_t reference_every = 1;  ///< 0 = never
  std::uint32_t pictures = 4;
  std::vector<std::uint32_t> dump;
};

class RunReport {
 public:
  /// `reference` may be null only if the wish asks for none.
  RunReport(RunReportOptions wish, Renderer& renderer, Reference* reference);

  /// A session must fill the report for these frames.
  [[nodiscard]] bool measures_any() const { return wish_.reference_every > 0 || !wish_.dump.empty(); }

  void watch(const FrameView& view);

  /// The first failure to write, after which no more is tried.
  [[nodiscard]] const std::optional<Error>& failed() const { return failed_; }
  [[nodiscard]] const FrameLog& log() const { return log_; }
  /// The frame watched last, if it was measured; else null.
  [[nodiscard]] const MeasuredFrame* measured() const {
    return !log_.records().empty() && log_.records().back().errors ? &current_ : nullptr;
  }

  /// Pictures of the worst frame, summary.csv and frames.csv.
  [[nodiscard]] Expected<void> finish() const;

 private:
  [[nodiscard]] bool is_pictured(FrameId frame) const;
  [[nodiscard]] bool is_dumped(FrameId frame) const;
  [[nodiscard]] static std::optional<double> guard_band_of(const FrameView& view);
  [[nodiscard]] static double badness(const EyeErrors& errors);
  void keep(Expected<void> done);

  RunReportOptions wish_;
  Renderer& renderer_;
  Reference* reference_;
  FrameLog log_;
  std::optional<FrameId> counted_;  ///< newest server frame in the log
  MeasuredFrame current_;
  std::optional<MeasuredFrame> worst_;
  double worst_error_ = -1;
  std::optional<Error> failed_;
};

}  // namespace farshade
