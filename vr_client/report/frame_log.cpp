#include "vr_client/report/frame_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace farshade {
namespace {

using Value = std::optional<double>;

constexpr double kDegrees = 180 / std::numbers::pi;

/// One figure of a frame, for the summary and for frames.csv.
struct Figure {
  std::string group, metric, unit;
  std::function<Value(const FrameRecord&)> of;
  Worse worse = Worse::High;
  bool of_eye = false;
};

std::vector<Figure> client_figures() {
  const auto stage = [](const char* metric, Duration StageTimes::*time) {
    return Figure{"client", metric, "ms",
                  [time](const FrameRecord& r) -> Value { return ms_of(r.times.*time); }};
  };
  const auto triangles = [](const char* metric, std::uint64_t DrawnTriangles::*of_pass) {
    return Figure{"client", metric, "", [of_pass](const FrameRecord& r) -> Value {
                    return static_cast<double>(r.times.triangles.*of_pass);
                  }};
  };
  return {stage("frame", &StageTimes::frame),
          stage("request", &StageTimes::request),
          stage("collect masks", &StageTimes::collect),
          stage("draw", &StageTimes::total),
          stage("G-buffer", &StageTimes::gbuffer),
          stage("depth of requested views", &StageTimes::depth),
          stage("carry over to requested views", &StageTimes::carry),
          stage("shadow maps", &StageTimes::maps),
          stage("reproject and shade", &StageTimes::shade),
          stage("turn", &StageTimes::turn),
          triangles("triangles of the G-buffer", &DrawnTriangles::gbuffer),
          triangles("triangles of requested views", &DrawnTriangles::depth),
          triangles("triangles of shadow maps", &DrawnTriangles::maps)};
}

double percent_of_full_trace(const FrameReport& report) {
  if (report.full_shadow_rays == 0) return 0;
  return 100.0 * static_cast<double>(report.shadow_rays) / static_cast<double>(report.full_shadow_rays);
}

std::vector<Figure> server_wire_and_head_figures() {
  /// The figure that `get` reads from `from`, an optional member of the record.
  const auto figure = [](const char* group, const char* metric, const char* unit, auto from, auto get) {
    return Figure{group, metric, unit, [=](const FrameRecord& r) -> Value {
                    return r.*from ? Value(static_cast<double>(get(*(r.*from)))) : std::nullopt;
                  }};
  };
  const auto server = [&](const char* metric, const char* unit, auto get) {
    return figure("server", metric, unit, &FrameRecord::server, get);
  };
  using Report = FrameReport;
  return {server("frame", "ms", [](const Report& r) { return ms_of(total_work(r)); }),
          server("primary visibility", "ms", [](const Report& r) { return ms_of(r.primary); }),
          server("shadow rays", "ms", [](const Report& r) { return ms_of(r.shadow); }),
          server("draw", "ms", [](const Report& r) { return ms_of(r.draw); }),
          server("code and pack", "ms", [](const Report& r) { return ms_of(r.pack); }),
          server("request waited", "ms", [](const Report& r) { return ms_of(r.waited); }),
          server("primary rays", "rays", [](const Report& r) { return r.primary_rays; }),
          server("shadow rays", "rays", [](const Report& r) { return r.shadow_rays; }),
          server("share of a full trace", "%", percent_of_full_trace),
          figure("wire", "bytes down a frame", "B", &FrameRecord::traffic,
                 [](const LinkTraffic& traffic) { return traffic.down; }),
          figure("wire", "bytes up a frame", "B", &FrameRecord::traffic,
                 [](const LinkTraffic& traffic) { return traffic.up; }),
          figure("wire", "datagrams of an answer", "", &FrameRecord::server,
                 [](const Report& r) { return r.slices + 1.0; }),
          figure("wire", "bytes of an answer", "B", &FrameRecord::server,
                 [](const Report& r) { return r.payload_bytes; }),
          figure("wire", "asked for", "% of the views", &FrameRecord::asked,
                 [](double share) { return share * 100; }),
          figure("server", "frame of the surround", "ms", &FrameRecord::surround,
                 [](const SurroundCost& cost) { return ms_of(cost.server); }),
          figure("server", "rays of the surround", "rays", &FrameRecord::surround,
                 [](const SurroundCost& cost) { return cost.rays; }),
          figure("wire", "bytes of the surround", "B", &FrameRecord::surround,
                 [](const SurroundCost& cost) { return cost.bytes; }),
          figure("wire", "staleness", "ms", &FrameRecord::delta,
                 [](const PoseDelta& d) { return std::abs(ms_of(d.age)); }),
          figure("wire", "age", "ms", &FrameRecord::age, [](Duration age) { return ms_of(age); }),
          figure("head", "turned since traced view", "deg", &FrameRecord::delta,
                 [](const PoseDelta& d) { return d.angle_rad * kDegrees; }),
          figure("head", "moved since traced view", "mm", &FrameRecord::delta,
                 [](const PoseDelta& d) { return d.distance_m * 1e3; }),
          figure("head", "guard band", "% of pixels", &FrameRecord::guard_band,
                 [](double share) { return share * 100; })};
}

std::vector<Figure> eye_figures(Side side) {
  const std::string group = std::string(name_of(side)) + " eye";
  const auto error = [&](const char* metric, const char* unit, Worse worse, double (*get)(const EyeErrors&)) {
    return Figure{group, metric, unit,
                  [get, side](const FrameRecord& r) -> Value {
                    if (!r.errors || r.start_up) return std::nullopt;
                    const EyeErrors& eye = (*r.errors)[index_of(side)];
                    const double value = eye.covered == 0 ? kNotMeasured : get(eye);
                    return std::isnan(value) ? std::nullopt : Value(value);
                  },
                  worse};
  };
  const auto percent = [&](const char* metric, double (*get)(const EyeErrors&), Worse worse = Worse::High) {
    return error(metric, "%", worse, get);
  };
  return {
      percent("mask error", [](const EyeErrors& e) { return 100 * e.mask_error; }),
      percent("mask error among known", [](const EyeErrors& e) { return 100 * e.known_error; }),
      percent("mask error unreprojected",
              [](const EyeErrors& e) { return 100 * e.unmoved_error.value_or(kNotMeasured); }),
      error("PSNR", "dB", Worse::Low, [](const EyeErrors& e) { return e.psnr_db; }),
      error("PSNR to smooth edges", "dB", Worse::Low, [](const EyeErrors& e) { return e.smooth_psnr_db; }),
      percent(
          "from newest mask", [](const EyeErrors& e) { return 100 * e.newest; }, Worse::Low),
      percent("from other eye's newest", [](const EyeErrors& e) { return 100 * e.other_eye; }),
      percent("from older masks", [](const EyeErrors& e) { return 100 * e.older; }),
      percent("from the surround", [](const EyeErrors& e) { return 100 * e.surround; }),
      percent("neighbours", [](const EyeErrors& e) { return 100 * e.neighbours; }),
      percent("unknown", [](const EyeErrors& e) { return 100 * e.unknown; }),
      percent("stale", [](const EyeErrors& e) { return 100 * e.stale; }),
      {group, "shows a surface", "% of pixels",
       [side](const FrameRecord& r) -> Value {
         if (!r.errors || std::isnan((*r.errors)[index_of(side)].covered)) return std::nullopt;
         return 100 * (*r.errors)[index_of(side)].covered;
       },
       Worse::Low},
      {group, "not reached by the picture", "%", [side](const FrameRecord& r) -> Value {
         return r.start_up ? std::nullopt : Value(100 * r.black[index_of(side)]);
       }}};
}

/// All figures, in the order of the summary's rows and of the columns of frames.csv.
std::vector<Figure> figures() {
  std::vector<Figure> all;
  for (const auto& part : {client_figures(), server_wire_and_head_figures()})
    all.insert(all.end(), part.begin(), part.end());
  for (const Side side : kSides)
    for (Figure& figure : eye_figures(side)) {
      figure.of_eye = true;
      all.push_back(std::move(figure));
    }
  return all;
}

/// Median and the quantiles on the worse side.
Spread spread_toward(Worse worse, std::vector<double> values) {
  if (worse == Worse::High) return spread_of(std::move(values));
  return {values.size(), quantile(values, 0.5), quantile(values, 0.05), quantile(values, 0.01)};
}

}  // namespace

std::size_t FrameLog::start_up_frames() const {
  return static_cast<std::size_t>(std::ranges::count_if(records_, &FrameRecord::start_up));
}

std::vector<SummaryRow> FrameLog::summary() const {
  std::vector<SummaryRow> rows;
  for (const Figure& figure : figures()) {
    std::vector<double> values;
    for (const FrameRecord& record : records_) {
      if (record.silent && !figure.of_eye) continue;
      if (const std::optional<double> value = figure.of(record)) values.push_back(*value);
    }
    if (!values.empty())
      rows.push_back(
          {figure.group, figure.metric, figure.unit, spread_toward(figure.worse, std::move(values))});
  }
  return rows;
}

std::string table(const std::vector<SummaryRow>& rows) {
  std::string text = fmt::format("{:<34}{:>12}{:>12}{:>12}\n", "", "median", "p95", "p99");
  std::string group;
  for (const SummaryRow& row : rows) {
    if (row.group != group) text += row.group + "\n";
    group = row.group;
    const std::string label = row.unit.empty() ? row.metric : row.metric + ", " + row.unit;
    const int digits = row.spread.median >= 1000 ? 0 : 3;
    text += fmt::format("  {:<32}{:>12.{}f}{:>12.{}f}{:>12.{}f}\n", label, row.spread.median, digits,
                        row.spread.p95, digits, row.spread.p99, digits);
  }
  return text;
}

std::string summary_csv(const std::vector<SummaryRow>& rows) {
  std::string text = "group,metric,unit,median,p95,p99,frames\n";
  for (const SummaryRow& row : rows)
    text += fmt::format("{},{},{},{:.6g},{:.6g},{:.6g},{}\n", row.group, row.metric, row.unit,
                        row.spread.median, row.spread.p95, row.spread.p99, row.spread.count);
  return text;
}

std::string frames_csv(const std::vector<FrameRecord>& records) {
  const std::vector<Figure> list = figures();
  std::string text = "frame,display_time_ns,server_silent";
  for (const Figure& figure : list)
    text += fmt::format(",{} {}{}", figure.group, figure.metric,
                        figure.unit.empty() ? "" : " [" + figure.unit + "]");
  text += '\n';
  for (const FrameRecord& record : records) {
    text += fmt::format("{},{},{:d}", record.frame.value, ns_of(record.display_time), record.silent);
    for (const Figure& figure : list) {
      const std::optional<double> value = figure.of(record);
      text += value ? fmt::format(",{:.6g}", *value) : ",";
    }
    text += '\n';
  }
  return text;
}

}  // namespace farshade
