#include "vr_client/report/timeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>

#include "stereo/base/files.h"

namespace farshade {
namespace {

/// The rows of the timeline, from the top. Frame, Device and Network belong to process 1, vr_client; Waiting
/// and Worker to process 2, rt_server.
enum class TraceRow : std::uint8_t { Frame, Device, Network, Waiting, Worker };

struct TraceStage {
  const char* name;
  Duration length;
};

struct RowName {
  int process;
  const char* thread;
};
constexpr std::array<RowName, 5> kRowNames{
    {{1, "frame"}, {1, "device"}, {1, "network"}, {2, "waiting"}, {2, "worker"}}};

/// Thread numbers are unique over both processes: 1000 for each row.
constexpr std::size_t kThreadsPerRow = 1000;

std::size_t thread_number(std::size_t row, std::size_t thread) {
  return row * kThreadsPerRow + thread + 1;
}

Duration total_of(std::span<const TraceStage> stages) {
  Duration total{};
  for (const TraceStage& stage : stages) total += stage.length;
  return total;
}

/// `part` of a `whole` that must fit into `room`: unchanged if it fits, else scaled down with the whole.
Duration fitted(Duration part, Duration whole, Duration room) {
  if (whole <= room) return part;
  return duration_from_ms(ms_of(room) * (seconds_of(part) / seconds_of(whole)));
}

/// Writes time spans and arrows in the Trace Event Format (Google, "Trace Event Format", 2016: the JSON
/// object form), which ui.perfetto.dev and chrome://tracing open.
class TraceEvents {
 public:
  struct Thread {
    int process;
    std::size_t number;
  };

  /// Times are written relative to `zero`, in microseconds, rounded down to an eighth.
  explicit TraceEvents(Time zero) : zero_(zero) {}

  /// A thread of `row` that has no span in `span`, and marks it as occupied. Adds a thread if all are
  /// occupied.
  Thread thread(TraceRow row, TimeSpan span);

  void add(const char* name, TimeSpan span, Thread on, FrameId frame);

  /// Adds the stages one after the other, scaled down if they are longer than `within`. Returns their begins.
  std::vector<Time> add_stages(std::span<const TraceStage> stages, TimeSpan within, Thread on, FrameId frame);

  /// Adds an arrow between the innermost spans that contain its ends.
  void add_arrow(const char* name, Time from, Thread from_thread, Time to, Thread to_thread, FrameId frame);

  /// Names the processes and threads and returns the whole JSON text.
  [[nodiscard]] std::string finish();

 private:
  static constexpr std::size_t kRows = 5;
  void add_arrow_end(const char* phase, const char* name, Time at, Thread on, FrameId frame);
  void append(const std::string& fields);
  [[nodiscard]] double microseconds(Time time) const;

  Time zero_;
  std::uint64_t arrows_ = 0;
  std::array<std::vector<Time>, kRows> ends_;  ///< end of the last span of each thread of each row
  std::string text_;
};

TraceEvents::Thread TraceEvents::thread(TraceRow row, TimeSpan span) {
  const auto index = static_cast<std::size_t>(row);
  std::vector<Time>& ends = ends_[index];
  auto free = std::ranges::find_if(ends, [&](Time end) { return end <= span.begin; });
  if (free == ends.end()) free = ends.insert(ends.end(), span.end);
  *free = span.end;
  return {kRowNames[index].process, thread_number(index, static_cast<std::size_t>(free - ends.begin()))};
}

void TraceEvents::add(const char* name, TimeSpan span, Thread on, FrameId frame) {
  const double begin = microseconds(span.begin), end = microseconds(span.end);
  append(
      fmt::format(R"("ph":"X","name":"{}","ts":{:.3f},"dur":{:.3f},"pid":{},"tid":{},"args":{{"frame":{}}})",
                  name, begin, end - begin, on.process, on.number, frame.value));
}

std::vector<Time> TraceEvents::add_stages(std::span<const TraceStage> stages, TimeSpan within, Thread on,
                                          FrameId frame) {
  const Duration total = total_of(stages), room = within.end - within.begin;
  std::vector<Time> begins;
  Duration before{};
  for (const TraceStage& stage : stages) {
    const Duration after = before + stage.length;
    const TimeSpan span{within.begin + fitted(before, total, room),
                        within.begin + fitted(after, total, room)};
    begins.push_back(span.begin);
    if (stage.length > Duration::zero()) add(stage.name, span, on, frame);
    before = after;
  }
  return begins;
}

void TraceEvents::add_arrow(const char* name, Time from, Thread from_thread, Time to, Thread to_thread,
                            FrameId frame) {
  ++arrows_;  // frame ids restart with each session, so they cannot identify an arrow
  add_arrow_end("s", name, from, from_thread, frame);
  add_arrow_end("f", name, to, to_thread, frame);
}

void TraceEvents::add_arrow_end(const char* phase, const char* name, Time at, Thread on, FrameId frame) {
  append(fmt::format(
      R"("ph":"{}","bp":"e","cat":"wire","name":"{}","id":{},"ts":{:.3f},"pid":{},"tid":{},"args":{{"frame":{}}})",
      phase, name, arrows_, microseconds(at), on.process, on.number, frame.value));
}

std::string TraceEvents::finish() {
  append(R"("ph":"M","name":"process_name","pid":1,"args":{"name":"vr_client"})");
  append(R"("ph":"M","name":"process_name","pid":2,"args":{"name":"rt_server"})");
  for (std::size_t row = 0; row < kRows; ++row)
    for (std::size_t i = 0; i < ends_[row].size(); ++i) {
      const int process = kRowNames[row].process;
      const std::size_t number = thread_number(row, i);
      append(fmt::format(R"("ph":"M","name":"thread_name","pid":{},"tid":{},"args":{{"name":"{}"}})", process,
                         number, kRowNames[row].thread));
      append(
          fmt::format(R"("ph":"M","name":"thread_sort_index","pid":{},"tid":{},"args":{{"sort_index":{}}})",
                      process, number, number));
    }
  return "{\"traceEvents\":[\n" + text_ + "\n],\"displayTimeUnit\":\"ms\"}\n";
}

/// The names are constants of this program, so that they need no escapes.
void TraceEvents::append(const std::string& fields) {
  text_ += (text_.empty() ? "{" : ",\n{") + fields + "}";
}

/// Doubles represent eighths exactly, also in nanoseconds. So a span that contains another one does so in
/// every reader.
double TraceEvents::microseconds(Time time) const {
  const auto eighths = (time - zero_).count() / 125;
  return static_cast<double>(eighths) / 8;
}

void write_frame(const auto& shown, TraceEvents& events) {
  const StageStarts& starts = shown.starts;
  const TimeSpan whole{starts.request, starts.end};
  // A request that was sent late waited for its part of the device's work, while the picture was drawn.
  const bool is_late = starts.requested_late.has_value();
  const bool reprojects = shown.drawn.request_reprojection > Duration::zero();
  const TimeSpan draw{starts.draw,
                      is_late ? starts.end : std::min(starts.draw + shown.drawn.total, starts.end)};
  const auto frame = events.thread(TraceRow::Frame, whole);
  events.add("frame", whole, frame, shown.frame);
  events.add("request", {starts.request, starts.collect}, frame, shown.frame);
  events.add("collect", {starts.collect, starts.draw}, frame, shown.frame);
  events.add("draw", draw, frame, shown.frame);
  if (is_late) events.add("request", {starts.submitted, *starts.requested_late}, frame, shown.frame);

  // Before a request that asks for a part of its views their depth is drawn and a mask reprojected.
  std::vector<TraceStage> passes;
  if (reprojects) passes = {{"depth", shown.drawn.depth}, {"carry", shown.drawn.request_reprojection}};
  if (reprojects && !is_late) {
    const std::vector<TraceStage> before = std::exchange(passes, {});
    const TimeSpan requested{std::max(starts.request, starts.collect - total_of(before)), starts.collect};
    events.add_stages(before, requested, events.thread(TraceRow::Device, requested), shown.frame);
  }
  passes.insert(passes.end(), {{"G-buffer", shown.drawn.gbuffer},
                               {"depth", reprojects ? Duration::zero() : shown.drawn.depth},
                               {"shade", shown.drawn.shade}});
  const bool in_flight = shown.drawn.frames_ago > 0;
  if (in_flight && !shown.finished) return;
  const Duration total = total_of(passes);
  const Time ready = in_flight ? shown.finished->ready : draw.end;
  const TimeSpan device{in_flight ? ready - total : std::max(draw.begin, ready - total), ready};
  events.add_stages(passes, device, events.thread(TraceRow::Device, device),
                    in_flight ? shown.finished->frame : shown.frame);
}

void write_request(const auto& request, TraceEvents& events) {
  const auto& [frame, sent, first, last] = request.exchange;
  if (!first) return;
  const TimeSpan datagrams{std::min(*first, last.value_or(*first)), std::max(*first, last.value_or(*first))};
  events.add("datagrams", datagrams, events.thread(TraceRow::Network, datagrams), frame);
  if (!request.report) return;

  const FrameReport& report = *request.report;
  std::vector<TraceStage> stages;
  if (report.update > Duration::zero()) stages.push_back({"update", report.update});
  stages.insert(stages.end(), {{"primary", report.primary}, {"shadow", report.shadow}});
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

}  // namespace

TimeSpan place_work(Time sent, Time first, Duration work) {
  const Duration between = std::max(first - sent, Duration::zero());
  work = std::clamp(work, Duration::zero(), between);
  const Time begin = sent + (between - work) / 2;
  return {begin, begin + work};
}

void Timeline::add(const FrameView& view, const FrameReceiver* receiver) {
  frames_.push_back(
      {.frame = view.shown.frame, .starts = view.starts, .drawn = view.times, .finished = view.finished});
  if (receiver == nullptr) return;
  // Frame ids restart with each session: earlier requests are complete when a new session begins.
  if (frames_.size() > 1 && !is_newer(view.shown.frame, frames_[frames_.size() - 2].frame))
    settled_ = requests_.size();
  if (view.request)
    if (const RequestRecord* const record = receiver->find(view.request->frame))
      requests_.push_back({.exchange = {record->request.frame, record->origin.sent, {}, {}}});
  for (std::size_t i = settled_; i < requests_.size(); ++i) {
    ServerRequest& request = requests_[i];
    const RequestRecord* const record = receiver->find(request.exchange.frame);
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

std::string Timeline::text() const {
  TraceEvents events(frames_.empty() ? Time{} : frames_.front().starts.request);
  for (const ShownFrame& frame : frames_) write_frame(frame, events);
  for (const ServerRequest& request : requests_) write_request(request, events);
  return events.finish();
}

Expected<void> Timeline::write(const std::filesystem::path& path) const {
  return path.empty() ? Expected<void>{} : write_file_atomically(path, text());
}

}  // namespace farshade
