/// FrameLog: the measurements of every frame, and their summary as median, p95 and p99.
#pragma once

#include <string>
#include <vector>

#include "stereo/base/quantile.h"
#include "vr_client/frame/frame_loop.h"
#include "vr_client/report/measure.h"

namespace farshade {

struct FrameRecord {
  FrameId frame;
  Time display_time;
  std::optional<Duration> age;  ///< since the newest mask was requested; empty without a mask from a server
  /// Of the left eye: from the view of the newest answer to the shown view.
  std::optional<PoseDelta> delta;
  bool start_up = false;  ///< no answer that the mode needs had arrived yet
  StageTimes times;
  PerEye<double> black{};            ///< share of each eye's pixels outside the server's picture
  std::optional<double> guard_band;  ///< requested pixels beyond the shown ones, as a share of the shown ones
  std::optional<FrameReport> server;        ///< of the answer that this frame was the first to show
  std::optional<PerEye<EyeErrors>> errors;  ///< empty if no reference was traced
  std::optional<double> asked{};            ///< the share of the requested views that the request asks for
  std::optional<SurroundCost> surround{};   ///< set if answers of the surround came
  std::optional<LinkTraffic> traffic{};     ///< since the frame before
  bool silent = false;  ///< the server answered nothing; the summary leaves out all but the errors
};

/// Which values of a figure are worse. Where low values are worse, p95 and p99 are the 5 % and 1 % quantiles.
enum class Worse : std::uint8_t { High, Low };

struct SummaryRow {
  std::string group, metric, unit;
  Spread spread;
};

class FrameLog {
 public:
  void add(const FrameRecord& record) { records_.push_back(record); }
  /// Adds the errors of a frame that was measured later.
  void set_errors(std::size_t record, const PerEye<EyeErrors>& errors) {
    records_.at(record).errors = errors;
  }
  [[nodiscard]] const std::vector<FrameRecord>& records() const { return records_; }

  /// Number of frames that were shown before any answer had arrived. The summary excludes their errors.
  [[nodiscard]] std::size_t start_up_frames() const;

  [[nodiscard]] std::vector<SummaryRow> summary() const;

 private:
  std::vector<FrameRecord> records_;
};

/// The summary as a text table.
[[nodiscard]] std::string table(const std::vector<SummaryRow>& rows);

/// `summary.csv`: group,metric,unit,median,p95,p99,frames.
[[nodiscard]] std::string summary_csv(const std::vector<SummaryRow>& rows);

/// `frames.csv`: one row per frame. A field without a measurement is empty.
[[nodiscard]] std::string frames_csv(const std::vector<FrameRecord>& records);

}  // namespace farshade
