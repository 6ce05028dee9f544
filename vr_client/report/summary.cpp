#include "vr_client/report/summary.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace farshade {
namespace {

using nlohmann::ordered_json;

bool is_printed(const SummaryRow& row, Mode mode, const std::optional<PictureError>& picture) {
  const Figure& figure = *row.figure;
  if ((figure.printed_in >> static_cast<unsigned>(mode) & 1u) == 0) return false;
  if (figure.side && picture && figure.side != picture->eye) return false;
  return row.spread.median != 0 || row.spread.p95 != 0 || row.spread.p99 != 0;
}

ordered_json json_of(const FigureText& text) {
  return {{"group", text.group},
          {"name", text.name},
          {"unit", text.unit},
          {"meaning", text.meaning},
          {"measured", text.measured}};
}

ordered_json json_of(const RunSetting& setting) {
  return {{"scene", setting.scene},
          {"head", setting.head},
          {"device", setting.device},
          {"mode", name_of(setting.mode)},
          {"eye_size_px", {setting.eye_size.width, setting.eye_size.height}},
          {"refresh_hz", setting.refresh_hz},
          {"clock", setting.pace == Pace::Real ? "real" : "virtual"},
          {"delay_ms", setting.pace == Pace::Real ? ordered_json() : ordered_json(setting.delay_ms)},
          {"interrupted", setting.interrupted}};
}

ordered_json json_of(const std::optional<TimeUse>& use) {
  if (!use) return nullptr;
  return {{"median_ms", use->median_ms},
          {"budget_ms", use->budget_ms},
          {"late_percent", 100 * use->late_share},
          {"fits", use->budget() == Budget::Kept}};
}

ordered_json json_of(const std::optional<ByteUse>& use) {
  if (!use) return nullptr;
  return {{"down_bytes_a_frame", use->down_bytes},
          {"up_bytes_a_frame", use->up_bytes},
          {"down_mbit_s", use->down_mbit_s},
          {"up_mbit_s", use->up_mbit_s},
          {"path_mbit_s", use->path ? ordered_json(use->path->down_mbit_s) : ordered_json()},
          {"view_size_percent", use->view_size_percent},
          {"fits", use->budget() == Budget::Kept}};
}

ordered_json json_of(const std::optional<PictureError>& picture) {
  if (!picture) return nullptr;
  ordered_json described{{"worse_eye", name_of(picture->eye)},
                         {"psnr_db_median", picture->psnr_db.median},
                         {"psnr_db_worst_1_percent", picture->psnr_db.p99}};
  if (const auto& error = picture->mask_error_percent) {
    described["mask_error_percent_median"] = error->median;
    described["mask_error_percent_worst_1_percent"] = error->p99;
  }
  return described;
}

ordered_json json_of(const SummaryRow& row) {
  ordered_json described = json_of(row.figure->text);
  described["group"] = row.figure->group();
  described["worse"] = row.figure->worse == Worse::High ? "high" : "low";
  described["median"] = row.spread.median;
  described["p95"] = row.spread.p95;
  described["p99"] = row.spread.p99;
  described["frames"] = row.spread.count;
  return described;
}

}  // namespace

std::string table(const FrameLog& log, Mode mode) {
  const std::optional<PictureError> picture = picture_error(log);
  std::string text = fmt::format("{:<34}{:>12}{:>12}{:>12}\n", "", "median", "p95", "p99");
  std::string group;
  for (const SummaryRow& row : log.summary()) {
    if (!is_printed(row, mode, picture)) continue;
    const Figure& figure = *row.figure;
    if (figure.group() != group) text += figure.group() + (figure.side ? " (the worse one)\n" : "\n");
    group = figure.group();
    const int digits = row.spread.median >= 1000 ? 0 : 3;
    text +=
        fmt::format("  {:<32}{:>12.{}f}{:>12.{}f}{:>12.{}f}\n", with_unit(figure.text.name, figure.text.unit),
                    row.spread.median, digits, row.spread.p95, digits, row.spread.p99, digits);
  }
  return text;
}

std::string summary_json(const RunSetting& setting, const RunTotals& totals, const FrameLog& log) {
  const Verdict verdict = verdict_of(log, totals);
  ordered_json summary{{"setting", json_of(setting)},
                       {"verdict",
                        {{"valid", verdict.is_valid},
                         {"fits", verdict.fits()},
                         {"in_words", in_words(verdict, totals)},
                         {"picture", json_of(verdict.picture)},
                         {"client", json_of(verdict.client)},
                         {"server", json_of(verdict.server)},
                         {"bytes", json_of(verdict.bytes)}}},
                       {"run", ordered_json::array()},
                       {"figures", ordered_json::array()}};
  for (const RunFigure& figure : run_figures()) {
    ordered_json described = json_of(figure.text);
    described["value"] = figure.of(totals);
    summary["run"].push_back(std::move(described));
  }
  for (const SummaryRow& row : log.summary()) summary["figures"].push_back(json_of(row));
  return summary.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace farshade
