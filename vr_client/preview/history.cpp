#include "vr_client/preview/history.h"

#include <algorithm>

#include "stereo/base/quantile.h"

namespace farshade {
namespace {

Duration not_below_zero(Duration span) {
  return std::max(span, Duration::zero());
}

template <class Values, class Get>
double median_of(const Values& values, const Get& get) {
  std::vector<double> picked;
  for (const auto& value : values) picked.push_back(get(value));
  return quantile(std::move(picked), 0.5);
}

}  // namespace

void History::read_link(const FrameView& view, const NetworkLink& link, Instant& instant) {
  const NetworkLink::Counters counters = link.counters();
  instant.received = counters.port.received;
  instant.received_bytes = counters.port.received_bytes;
  instant.missing = counters.missing;
  instant.sessions = counters.sessions;
  if (view.newest == nullptr || !view.newest->report) return;
  const FrameReport& report = *view.newest->report;
  newest_.rays = report.primary_rays + report.shadow_rays;
  newest_.server_ms = ms_of(total_work(report));
  if (const RequestRecord& record = *view.newest; record.report_arrived)
    newest_.round_trip_ms = ms_of(*record.report_arrived - record.origin.sent);
}

void History::add(const FrameView& view, const std::optional<PerEye<EyeErrors>>& errors,
                  const NetworkLink* link, Time now) {
  const StageTimes& times = view.times;
  const Duration watch = not_below_zero(now - view.starts.end);
  bars_.push_back({.request = times.request,
                   .collect = times.collect,
                   .gbuffer = times.gbuffer,
                   .depth = times.depth,
                   .shade = times.maps + times.shade + times.timewarp,
                   .other = not_below_zero(times.total - times.gbuffer - times.depth - times.maps -
                                           times.shade - times.timewarp),
                   .watch = watch});
  if (bars_.size() > kGraphFrames) bars_.pop_front();

  newest_.errors = errors;
  newest_.triangles = view.times.triangles;
  newest_.staleness_ms.reset();
  newest_.age_ms.reset();
  if (!view.masks.empty())
    newest_.staleness_ms = ms_of(std::chrono::abs(view.shown.display_time - view.masks[0].display_time));
  else if (view.newest)
    newest_.staleness_ms =
        ms_of(std::chrono::abs(view.shown.display_time - view.newest->request.display_time));
  if (view.age) newest_.age_ms = ms_of(*view.age);
  newest_.black_percent = 100 * std::max(view.black[0], view.black[1]);
  if (view.request) {
    newest_.requested = view.request->views[0].size;
    newest_.guard_band_percent = 100 * *guard_band_of(view);
  }
  Instant instant{.at = now, .frame_ms = ms_of(times.frame), .watch_ms = ms_of(watch)};
  if (link) read_link(view, *link, instant);
  instants_.push_back(instant);
  while (instants_.size() > 2 && now - instants_.front().at > kFigureSpan) instants_.pop_front();
}

Figures History::figures() const {
  Figures figures = newest_;
  if (instants_.empty()) return figures;
  figures.frame_ms = median_of(instants_, [](const Instant& instant) { return instant.frame_ms; });
  figures.watch_ms = median_of(instants_, [](const Instant& instant) { return instant.watch_ms; });
  const Instant &first = instants_.front(), &last = instants_.back();
  const double span_s = seconds_of(last.at - first.at);
  if (span_s <= 0) return figures;
  figures.frames_per_s = static_cast<double>(instants_.size() - 1) / span_s;
  figures.megabit_per_s = static_cast<double>(last.received_bytes - first.received_bytes) * 8e-6 / span_s;
  // The counter of missing datagrams restarts with each session, and decreases when a late datagram arrives.
  const auto received = static_cast<double>(last.received - first.received);
  const double missing = static_cast<double>(last.missing) - static_cast<double>(first.missing);
  if (last.sessions > 0 && last.sessions == first.sessions && received + missing > 0)
    figures.loss_percent = 100 * std::max(missing, 0.0) / (received + std::max(missing, 0.0));
  return figures;
}

}  // namespace farshade
