#include "vr_client/report/timeline.h"

#include <algorithm>
#include <array>

#include "stereo/base/files.h"
#include "vr_client/report/trace_events.h"

namespace farshade {

TimeSpan place_work(Time sent, Time first, Duration work) {
  const Duration between = std::max(first - sent, Duration::zero());
  work = std::clamp(work, Duration::zero(), between);
  const Time begin = sent + (between - work) / 2;
  return {begin, begin + work};
}

void Timeline::add(const FrameView& view, const AnswerInbox* inbox) {
  frames_.push_back({.frame = view.shown.frame,
                     .starts = view.starts,
                     .gbuffer = view.times.gbuffer,
                     .depth = view.times.depth,
                     .shade = view.times.shade,
                     .draw = view.times.draw});
  if (inbox == nullptr) return;
  // Frame ids restart with each session: earlier requests are complete when a new session begins.
  if (frames_.size() > 1 && !is_newer(view.shown.frame, frames_[frames_.size() - 2].frame))
    settled_ = requests_.size();
  if (view.asked)
    if (const RequestRecord* const record = inbox->find(view.asked->frame))
      requests_.push_back({.exchange = {record->request.frame, record->origin.sent, {}, {}}});
  for (std::size_t i = settled_; i < requests_.size(); ++i) {
    ServerRequest& request = requests_[i];
    const RequestRecord* const record = inbox->find(request.exchange.frame);
    if (record) {
      request.exchange.first = record->first_piece;
      request.exchange.last = record->report_arrived;
      request.report = record->report;
    }
    const bool all_known = request.report && request.exchange.first;
    if (i == settled_ && (record == nullptr || all_known)) ++settled_;
  }
  if (view.masks.empty()) return;
  const auto of_mask = std::find_if(requests_.rbegin(), requests_.rend(), [&](const ServerRequest& request) {
    return request.exchange.frame == view.masks[0].frame;
  });
  if (of_mask != requests_.rend() && !of_mask->drawn) of_mask->drawn = view.starts.draw;
}

void Timeline::write_frame(const ShownFrame& shown, TraceEvents& events) {
  const StageStarts& starts = shown.starts;
  const TimeSpan whole{starts.request, starts.end};
  const TimeSpan draw{starts.draw, std::min(starts.draw + shown.draw, starts.end)};
  const auto frame = events.thread(TraceRow::Frame, whole);
  events.add("frame", whole, frame, shown.frame);
  events.add("request", {starts.request, starts.collect}, frame, shown.frame);
  events.add("collect", {starts.collect, starts.draw}, frame, shown.frame);
  events.add("draw", draw, frame, shown.frame);

  const std::array<TraceStage, 3> passes{
      {{"G-buffer", shown.gbuffer}, {"depth", shown.depth}, {"shade", shown.shade}}};
  const TimeSpan device{std::max(draw.begin, draw.end - total_of(passes)), draw.end};
  events.add_stages(passes, device, events.thread(TraceRow::Device, device), shown.frame);
}

void Timeline::write_request(const ServerRequest& request, TraceEvents& events) {
  const auto& [frame, sent, first, last] = request.exchange;
  if (!first) return;
  const TimeSpan datagrams{std::min(*first, last.value_or(*first)), std::max(*first, last.value_or(*first))};
  events.add("datagrams", datagrams, events.thread(TraceRow::Network, datagrams), frame);
  if (!request.report) return;

  const FrameReport& report = *request.report;
  std::vector<TraceStage> stages{{"primary", report.primary}, {"shadow", report.shadow}};
  if (report.draw > Duration::zero()) stages.push_back({"draw", report.draw});
  stages.push_back({"pack", report.pack});
  const Duration work = report.waited + total_of(stages);
  const TimeSpan placed = place_work(sent, *first, work);
  const Time begun = placed.begin + fitted(report.waited, work, placed.end - placed.begin);
  const TimeSpan waited{placed.begin, begun}, worked{begun, placed.end};
  events.add("waited", waited, events.thread(TraceRow::Waiting, waited), frame);
  const auto worker = events.thread(TraceRow::Worker, worked);
  events.add("work", worked, worker, frame);
  const std::vector<Time> begins = events.add_stages(stages, worked, worker, frame);
  const TraceEvents::Thread client{.process = 1,
                                   .number = 1};  // frames do not overlap: their row has one thread
  events.add_arrow("request", sent, client, begun, worker, frame);
  if (request.drawn) events.add_arrow("masks", begins.back(), worker, *request.drawn, client, frame);
}

std::string Timeline::text() const {
  TraceEvents events(frames_.empty() ? Time{} : frames_.front().starts.request);
  for (const ShownFrame& frame : frames_) write_frame(frame, events);
  for (const ServerRequest& request : requests_) write_request(request, events);
  return events.finish();
}

Expected<void> Timeline::write(const std::filesystem::path& path) const {
  return write_file_atomically(path, text());
}

}  // namespace farshade
