#include "vr_client/report/frame_log.h"

#include <fmt/format.h>

#include <algorithm>

namespace farshade {
Spread spread_toward(Worse worse, const std::vector<double>& values) {
  if (worse == Worse::High) return spread_of(values);
  return {values.size(), quantile(values, 0.5), quantile(values, 0.05), quantile(values, 0.01)};
}

std::size_t FrameLog::start_up_frames() const {
  return static_cast<std::size_t>(std::ranges::count_if(records_, &FrameRecord::start_up));
}

std::vector<double> FrameLog::values(const Figure& figure) const {
  std::vector<double> values;
  for (const FrameRecord& record : records_) {
    if (record.silent && !figure.side) continue;
    if (const std::optional<double> value = figure.of(record)) values.push_back(*value);
  }
  return values;
}

std::vector<SummaryRow> FrameLog::summary() const {
  std::vector<SummaryRow> rows;
  for (const Figure& figure : figures())
    if (const std::vector<double> found = values(figure); !found.empty())
      rows.push_back({&figure, spread_toward(figure.worse, found)});
  return rows;
}

std::string summary_csv(const std::vector<SummaryRow>& rows) {
  std::string text = "group,metric,unit,median,p95,p99,frames\n";
  for (const SummaryRow& row : rows)
    text += fmt::format("{},{},{},{:.6g},{:.6g},{:.6g},{}\n", row.figure->group(), row.figure->text.name,
                        row.figure->text.unit, row.spread.median, row.spread.p95, row.spread.p99,
                        row.spread.count);
  return text;
}

std::string frames_csv(const std::vector<FrameRecord>& records) {
  std::string text = "frame,display_time_ns,server_silent";
  for (const Figure& figure : figures())
    text += fmt::format(",{} {}{}", figure.group(), figure.text.name,
                        figure.text.unit.empty() ? "" : " [" + figure.text.unit + "]");
  text += '\n';
  for (const FrameRecord& record : records) {
    text += fmt::format("{},{},{:d}", record.frame.value, ns_of(record.display_time), record.silent);
    for (const Figure& figure : figures()) {
      const std::optional<double> value = figure.of(record);
      text += value ? fmt::format(",{:.6g}", *value) : ",";
    }
    text += '\n';
  }
  return text;
}

}  // namespace farshade
