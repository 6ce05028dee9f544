#include "vr_client/report/timeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>

#include "stereo/base/files.h"

namespace farshade {
namespace {

/// Threads as a viewer shows them, from the top.
enum class Row : std::uint8_t { Frame, Device, Network, Waiting, Worker };
struct RowName {
  int process;
  const char* thread;
};
constexpr std::array<RowName, 5> kRows{
    {{1, "frame"}, {1, "device"}, {1, "network"}, {2, "waiting"}, {2, "worker"}}};
/// Numbers of threads, so that they are told apart across processes too.
constexpr std::size_t kThreadsARow = 1000;

struct Part {
  const char* name;
  Duration length;
};

Duration total_of(std::span<const Part> parts) {
  Duration total{};
  for (const Part& part : parts) total += part.length;
  return total;
}

/// `part` of a `whole` that should take no more than `room`: as it is, or scaled down with the whole.
Duration fitted(Duration part, Duration whole, Duration room) {
  if (whole <= room) return part;
  return duration_from_ms(ms_of(room) * (seconds_of(part) / seconds_of(whole)));
}

}  // namespace

TimeSpan place_work(Time sent, Time first, Duration work) {
  const Duration between = std::max(first - sent, Duration::zero());
  work = std::clamp(work, Duration::zero(), between);
  const Time begin = sent + (between - work) / 2;
  return {begin, begin + work};
}

/// Writes events, and sees to it that those of one thread do not overlap but where one holds the other.
class Timeline::Events {
 public:
  explicit Events(Time zero) : zero_(zero) {}

  /// A thread of `row` on which nothing is going on in `span`.
  struct Thread {
    int process;
    std::size_t number;
  };
  Thread thread(Row row, TimeSpan span) {
    std::vector<Time>& ends = ends_[static_cast<std::size_t>(row)];
    auto free = std::ranges::find_if(ends, [&](Time end) { return end <= span.begin; });
    if (free == ends.end()) free = ends.insert(ends.end(), span.end);
    *free = span.end;
    return {kRows[static_cast<std::size_t>(row)].process,
            static_cast<std::size_t>(row) * kThreadsARow + static_cast<std::size_t>(free - ends.begin()) + 1};
  }

  void add(const char* name, TimeSpan span, Thread on, FrameId frame) {
    event(R"("ph":"X","name":"{}","ts":{:.3f},"dur":{:.3f},"pid":{},"tid":{},"args":{{"frame":{}}})", name,
          us(span.begin), us(span.end) - us(span.begin), on.process, on.number, frame.value);
  }

  /// End to end, scaled down to what of `within` is left where they are longer. Returns when each began.
  std::vector<Time> add_row(std::span<const Part> parts, TimeSpan within, Thread on, FrameId frame) {
    const Duration total = total_of(parts), room = within.end - within.begin;
    std::vector<Time> begins;
    Duration before{};
    for (const Part& part : parts) {
      const Duration after = before + part.length;
      const TimeSpan span{within.begin + fitted(before, total, room),
                          within.begin + fitted(after, total, room)};
      begins.push_back(span.begin);
      if (part.length > Duration::zero()) add(part.name, span, on, frame);
      before = after;
    }
    return begins;
  }

  /// An arrow between the innermost spans that hold its ends.
  void arrow(const char* name, Time from, Thread from_thread, Time to, Thread to_thread, FrameId frame) {
    ++arrows_;  // frame ids begin anew with each session, arrows do not
    arrow_end("s", name, from, from_thread, frame);
    arrow_end("f", name, to, to_thread, frame);
  }

  /// Names processes and threads and closes the text.
  std::string finish() {
    constexpr std::array processes{"vr_client", "rt_server"};
    for (std::size_t i = 0; i < processes.size(); ++i)
      event(R"("ph":"M","name":"process_name","pid":{},"args":{{"name":"{}"}})", i + 1, processes[i]);
    for (std::size_t row = 0; row < kRows.size(); ++row)
      for (std::size_t i = 0; i < ends_[row].size(); ++i) {
        const std::size_t number = row * kThreadsARow + i + 1;
        event(R"("ph":"M","name":"thread_name","pid":{},"tid":{},"args":{{"name":"{}"}})", kRows[row].process,
              number, kRows[row].thread);
        event(R"("ph":"M","name":"thread_sort_index","pid":{},"tid":{},"args":{{"sort_index":{}}})",
              kRows[row].process, number, number);
      }
    return "{\"traceEvents\":[\n" + text_ + "\n],\"displayTimeUnit\":\"ms\"}\n";
  }

 private:
  /// Rounded down to an eighth: doubles hold eighths exactly, also in nanoseconds, so that spans hold each
  /// other in every reader.
  [[nodiscard]] double us(Time time) const { return static_cast<double>((time - zero_).count() / 125) / 8; }

  /// Names are ours and need no escapes.
  template <class... Values>
  void event(fmt::format_string<Values...> format, Values&&... values) {
    text_ += text_.empty() ? "{" : ",\n{";
    fmt::format_to(std::back_inserter(text_), format, std::forward<Values>(values)...);
    text_ += '}';
  }

  void arrow_end(const char* phase, const char* name, Time at, Thread on, FrameId frame) {
    event(
        R"("ph":"{}","bp":"e","cat":"wire","name":"{}","id":{},"ts":{:.3f},"pid":{},"tid":{},"args":{{"frame":{}}})",
        phase, name, arrows_, us(at), on.process, on.number, frame.value);
  }

  Time zero_;
  std::uint64_t arrows_ = 0;
  std::array<std::vector<Time>, kRows.size()> ends_;  ///< of each row's threads: of the last span
  std::string text_;
};

void Timeline::add(const FrameView& view, const AnswerInbox* inbox) {
  shown_.push_back({.frame = view.shown.frame,
                    .starts = view.starts,
                    .gbuffer = view.times.gbuffer,
                    .depth = view.times.depth,
                    .shade = view.times.shade,
                    .draw = view.times.draw});
  if (inbox == nullptr) return;
  // Another session has begun: its frames are not those that were asked for before.
  if (shown_.size() > 1 && !is_newer(view.shown.frame, shown_[shown_.size() - 2].frame))
    settled_ = asked_.size();
  if (view.asked)
    if (const RequestRecord* const record = inbox->find(view.asked->frame))
      asked_.push_back({.exchange = {record->request.frame, record->origin.sent, {}, {}}});
  for (std::size_t i = settled_; i < asked_.size(); ++i) {
    Asked& asked = asked_[i];
    const RequestRecord* const record = inbox->find(asked.exchange.frame);
    if (record) {
      asked.exchange.first = record->first_piece;
      asked.exchange.last = record->report_arrived;
      asked.report = record->report;
    }
    const bool all_known = asked.report && asked.exchange.first;
    if (i == settled_ && (record == nullptr || all_known)) ++settled_;
  }
  if (view.masks.empty()) return;
  const auto of_mask = std::find_if(asked_.rbegin(), asked_.rend(), [&](const Asked& asked) {
    return asked.exchange.frame == view.masks[0].frame;
  });
  if (of_mask != asked_.rend() && !of_mask->drawn) of_mask->drawn = view.starts.draw;
}

void Timeline::write_shown(const Shown& shown, Events& events) {
  const StageStarts& starts = shown.starts;
  const TimeSpan whole{starts.request, starts.end};
  const TimeSpan draw{starts.draw, std::min(starts.draw + shown.draw, starts.end)};
  const auto frame = events.thread(Row::Frame, whole);
  events.add("frame", whole, frame, shown.frame);
  events.add("request", {starts.request, starts.collect}, frame, shown.frame);
  events.add("collect", {starts.collect, starts.draw}, frame, shown.frame);
  events.add("draw", draw, frame, shown.frame);

  const std::array<Part, 3> passes{
      {{"G-buffer", shown.gbuffer}, {"depth", shown.depth}, {"shade", shown.shade}}};
  const TimeSpan device{std::max(draw.begin, draw.end - total_of(passes)), draw.end};
  events.add_row(passes, device, events.thread(Row::Device, device), shown.frame);
}

void Timeline::write_asked(const Asked& asked, Events& events) {
  const auto& [frame, sent, first, last] = asked.exchange;
  if (!first) return;
  const TimeSpan datagrams{std::min(*first, last.value_or(*first)), std::max(*first, last.value_or(*first))};
  events.add("datagrams", datagrams, events.thread(Row::Network, datagrams), frame);
  if (!asked.report) return;

  const FrameReport& report = *asked.report;
  std::vector<Part> stages{{"primary", report.primary}, {"shadow", report.shadow}};
  if (report.draw > Duration::zero()) stages.push_back({"draw", report.draw});
  stages.push_back({"pack", report.pack});
  const Duration work = report.waited + total_of(stages);
  const TimeSpan placed = place_work(sent, *first, work);
  const Time begun = placed.begin + fitted(report.waited, work, placed.end - placed.begin);
  const TimeSpan waited{placed.begin, begun}, worked{begun, placed.end};
  events.add("waited", waited, events.thread(Row::Waiting, waited), frame);
  const auto worker = events.thread(Row::Worker, worked);
  events.add("work", worked, worker, frame);
  const std::vector<Time> begins = events.add_row(stages, worked, worker, frame);
  const Events::Thread client{kRows[0].process, 1};  // frames do not overlap: the row has one thread
  events.arrow("request", sent, client, begun, worker, frame);
  if (asked.drawn) events.arrow("masks", begins.back(), worker, *asked.drawn, client, frame);
}

std::string Timeline::text() const {
  Events events(shown_.empty() ? Time{} : shown_.front().starts.request);
  for (const Shown& shown : shown_) write_shown(shown, events);
  for (const Asked& asked : asked_) write_asked(asked, events);
  return events.finish();
}

Expected<void> Timeline::write(const std::filesystem::path& path) const {
  return write_file_atomically(path, text());
}

}  // namespace farshade
