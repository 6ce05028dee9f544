/// FrameLog: the measurements of every frame, and their summary as median, p95 and p99.
#pragma once

#include <string>
#include <vector>

#include "stereo/base/quantile.h"
#include "vr_client/report/figures.h"

namespace farshade {

/// Median and the quantiles on the worse side.
[[nodiscard]] Spread spread_toward(Worse worse, const std::vector<double>& values);

struct SummaryRow {
  const Figure* figure;  ///< of figures()
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

  /// The values of a figure, without those of silent frames unless it is a figure of the eyes.
  [[nodiscard]] std::vector<double> values(const Figure& figure) const;

  /// All figures that have a value.
  [[nodiscard]] std::vector<SummaryRow> summary() const;

 private:
  std::vector<FrameRecord> records_;
};

/// `summary.csv`: group,metric,unit,median,p95,p99,frames.
[[nodiscard]] std::string summary_csv(const std::vector<SummaryRow>& rows);

/// `frames.csv`: one row per frame. A field without a measurement is empty.
[[nodiscard]] std::string frames_csv(const std::vector<FrameRecord>& records);

}  // namespace farshade
