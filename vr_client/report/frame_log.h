/// FrameLog: what was measured of every frame, and its summary: median, p95 and p99, never a mean alone.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "stereo/base/quantile.h"
#include "vr_client/frame/frame_loop.h"
#include "vr_client/report/measure.h"

namespace farshade {

struct FrameRecord {
  FrameId frame;
  Time display_time;
  std::optional<Duration> age;  ///< since the newest mask was asked for; nothing where no server sent one
  std::optional<PoseDelta>
      delta;              ///< the left eye's, from what the newest answer was made for to what was shown
  bool start_up = false;  ///< nothing of what the mode needs had come
  StageTimes times;
  PerEye<double> black{};                   ///< share of each eye that the server's picture does not reach
  std::optional<double> guard_band;         ///< pixels asked for beyond those shown, as a share of these
  std::optional<FrameReport> server;        ///< of masks first shown in this frame
  std::optional<PerEye<EyeErrors>> errors;  ///< nothing if no reference was traced
};

/// Percentiles point to the worse side: for `LowIsWorse` rows p95 and p99 are the 5 % and 1 % quantiles.
enum class Worse : std::uint8_t { High, Low };

struct SummaryRow {
  std::string group, metric, unit;
  Spread spread;
};

class FrameLog {
 public:
  void add(const FrameRecord& record) { records_.push_back(record); }
  [[nodiscard]] const std::vector<FrameRecord>& records() const { return records_; }

  /// Frames shown before anything had come; their errors are not part of the summary.
  [[nodiscard]] std::size_t start_up_frames() const;

  [[nodiscard]] std::vector<SummaryRow> summary() const;

 private:
  std::vector<FrameRecord> records_;
};

/// A table for people.
[[nodiscard]] std::string table(const std::vector<SummaryRow>& rows);

/// `summary.csv`: group,metric,unit,median,p95,p99,frames.
[[nodiscard]] std::string summary_csv(const std::vector<SummaryRow>& rows);

/// `frames.csv`: one row a frame; empty fields where nothing was measured.
[[nodiscard]] std::string frames_csv(const std::vector<FrameRecord>& records);

}  // namespace farshade
