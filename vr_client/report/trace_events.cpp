#include "vr_client/report/trace_events.h"

#include <fmt/format.h>

#include <algorithm>

namespace farshade {
namespace {

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

}  // namespace

Duration total_of(std::span<const TraceStage> stages) {
  Duration total{};
  for (const TraceStage& stage : stages) total += stage.length;
  return total;
}

Duration fitted(Duration part, Duration whole, Duration room) {
  if (whole <= room) return part;
  return duration_from_ms(ms_of(room) * (seconds_of(part) / seconds_of(whole)));
}

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
  return static_cast<double>((time - zero_).count() / 125) / 8;
}

}  // namespace farshade
