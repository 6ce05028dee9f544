#include "vr_client/report/frame_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace farshade {
namespace {

/// One figure of a frame, for the summary and for frames.csv alike.
struct Figure {
  std::string group, metric, unit;
  std::function<std::optional<double>(const FrameRecord&)> of;
  Worse worse = Worse::High;
};

template <class Get>
Figure client_ms(std::string metric, Get get) {
  return {"client", std::move(metric), "ms",
          [get](const FrameRecord& r) -> std::optional<double> { return ms_of(get(r.times)); }};
}

template <class Get>
Figure server(std::string metric, std::string unit, Get get, Worse worse = Worse::High) {
  return {"server", std::move(metric), std::move(unit),
          [get](const FrameRecord& r) -> std::optional<double> {
            if (!r.server) return std::nullopt;
            return static_cast<double>(get(*r.server));
          },
          worse};
}

template <class Get>
Figure error(Side side, std::string metric, std::string unit, Worse worse, Get get) {
  return {std::string(name_of(side)) + " eye", std::move(metric), std::move(unit),
          [get, side](const FrameRecord& r) -> std::optional<double> {
            if (!r.errors || r.start_up) return std::nullopt;
            const double value = get((*r.errors)[index_of(side)]);
            return std::isnan(value) ? std::nullopt : std::optional(value);
          },
          worse};
}

std::vector<Figure> figures() {
  std::vector<Figure> list{
      client_ms("frame", [](const StageTimes& t) { return t.frame; }),
      client_ms("request", [](const StageTimes& t) { return t.request; }),
      client_ms("collect masks", [](const StageTimes& t) { return t.collect; }),
      client_ms("draw", [](const StageTimes& t) { return t.draw; }),
      client_ms("G-buffer", [](const StageTimes& t) { return t.gbuffer; }),
      client_ms("depth of requested views", [](const StageTimes& t) { return t.depth; }),
      client_ms("shadow maps", [](const StageTimes& t) { return t.maps; }),
      client_ms("reproject and shade", [](const StageTimes& t) { return t.shade; }),
      client_ms("turn", [](const StageTimes& t) { return t.turn; }),
      server("frame", "ms",
             [](const FrameReport& r) { return ms_of(r.primary + r.shadow + r.draw + r.pack); }),
      server("primary visibility", "ms", [](const FrameReport& r) { return ms_of(r.primary); }),
      server("shadow rays", "ms", [](const FrameReport& r) { return ms_of(r.shadow); }),
      server("draw", "ms", [](const FrameReport& r) { return ms_of(r.draw); }),
      server("code and pack", "ms", [](const FrameReport& r) { return ms_of(r.pack); }),
      server("request waited", "ms", [](const FrameReport& r) { return ms_of(r.waited); }),
      server("primary rays", "rays", [](const FrameReport& r) { return r.primary_rays; }),
      server("shadow rays", "rays", [](const FrameReport& r) { return r.shadow_rays; }),
      server("share of a full trace", "%",
             [](const FrameReport& r) {
               return r.full_shadow_rays == 0 ? 0.0
                                              : 100.0 * static_cast<double>(r.shadow_rays) /
                                                    static_cast<double>(r.full_shadow_rays);
             }),
      {"wire", "datagrams a frame", "",
       [](const FrameRecord& r) -> std::optional<double> {
         if (!r.server) return std::nullopt;
         return r.server->slices + 1.0;
       }},
      {"wire", "bytes a frame", "B",
       [](const FrameRecord& r) -> std::optional<double> {
         if (!r.server) return std::nullopt;
         return r.server->payload_bytes;
       }},
      {"wire", "staleness", "ms",
       [](const FrameRecord& r) -> std::optional<double> {
         if (!r.delta) return std::nullopt;
         return ms_of(r.delta->age);
       }},
      {"wire", "age", "ms",
       [](const FrameRecord& r) -> std::optional<double> {
         if (!r.age) return std::nullopt;
         return ms_of(*r.age);
       }},
      {"head", "turned since traced view", "deg",
       [](const FrameRecord& r) -> std::optional<double> {
         if (!r.delta) return std::nullopt;
         return r.delta->angle_rad * 180 / std::numbers::pi;
       }},
      {"head", "moved since traced view", "mm",
       [](const FrameRecord& r) -> std::optional<double> {
         if (!r.delta) return std::nullopt;
         return r.delta->distance_m * 1e3;
       }},
      {"head", "guard band", "% of pixels",
       [](const FrameRecord& r) -> std::optional<double> {
         if (!r.guard_band) return std::nullopt;
         return *r.guard_band * 100;
       }},
  };
  for (const Side side : kSides) {
    list.push_back(
        error(side, "mask error", "%", Worse::High, [](const EyeErrors& e) { return 100 * e.mask_error; }));
    list.push_back(error(side, "mask error among known", "%", Worse::High,
                         [](const EyeErrors& e) { return 100 * e.known_error; }));
    list.push_back(error(side, "mask error unreprojected", "%", Worse::High,
                         [](const EyeErrors& e) { return 100 * e.unmoved_error.value_or(kNotMeasured); }));
    list.push_back(error(side, "PSNR", "dB", Worse::Low, [](const EyeErrors& e) { return e.psnr_db; }));
    list.push_back(
        error(side, "from newest mask", "%", Worse::Low, [](const EyeErrors& e) { return 100 * e.newest; }));
    list.push_back(error(side, "from other eye's newest", "%", Worse::High,
                         [](const EyeErrors& e) { return 100 * e.other_eye; }));
    list.push_back(
        error(side, "from older masks", "%", Worse::High, [](const EyeErrors& e) { return 100 * e.older; }));
    list.push_back(
        error(side, "neighbours", "%", Worse::High, [](const EyeErrors& e) { return 100 * e.neighbours; }));
    list.push_back(
        error(side, "unknown", "%", Worse::High, [](const EyeErrors& e) { return 100 * e.unknown; }));
    list.push_back(error(side, "stale", "%", Worse::High, [](const EyeErrors& e) { return 100 * e.stale; }));
    list.push_back({std::string(name_of(side)) + " eye", "not reached by the picture", "%",
                    [side](const FrameRecord& r) -> std::optional<double> {
                      return r.start_up ? std::nullopt : std::optional(100 * r.black[index_of(side)]);
                    },
                    Worse::High});
  }
  return list;
}

Spread toward(Worse worse, std::vector<double> values) {
  if (worse == Worse::High) return spread_of(std::move(values));
  return {values.size(), quantile(values, 0.5), quantile(values, 0.05), quantile(values, 0.01)};
}

}  // namespace

std::size_t FrameLog::start_up_frames() const {
  return static_cast<std::size_t>(std::count_if(records_.begin(), records_.end(),
                                                [](const FrameRecord& record) { return record.start_up; }));
}

std::vector<SummaryRow> FrameLog::summary() const {
  std::vector<SummaryRow> rows;
  for (const Figure& figure : figures()) {
    std::vector<double> values;
    for (const FrameRecord& record : records_)
      if (const std::optional<double> value = figure.of(record)) values.push_back(*value);
    if (!values.empty())
      rows.push_back({figure.group, figure.metric, figure.unit, toward(figure.worse, std::move(values))});
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
  std::string text = "frame,display_time_ns";
  for (const Figure& figure : list)
    text += fmt::format(",{} {}{}", figure.group, figure.metric,
                        figure.unit.empty() ? "" : " [" + figure.unit + "]");
  text += '\n';
  for (const FrameRecord& record : records) {
    text += fmt::format("{},{}", record.frame.value, ns_of(record.display_time));
    for (const Figure& figure : list) {
      const std::optional<double> value = figure.of(record);
      text += value ? fmt::format(",{:.6g}", *value) : ",";
    }
    text += '\n';
  }
  return text;
}

}  // namespace farshade
