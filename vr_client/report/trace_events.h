/// TraceEvents: writes time spans and arrows in the Trace Event Format (Google, "Trace Event Format", 2016:
/// the JSON object form), which ui.perfetto.dev and chrome://tracing open.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "stereo/base/clock.h"
#include "stereo/frame/frame_id.h"

namespace farshade {

struct TimeSpan {
  Time begin, end;
};

/// The rows of the timeline, from the top. Frame, Device and Network belong to process 1, vr_client; Waiting
/// and Worker to process 2, rt_server.
enum class TraceRow : std::uint8_t { Frame, Device, Network, Waiting, Worker };

struct TraceStage {
  const char* name;
  Duration length;
};

[[nodiscard]] Duration total_of(std::span<const TraceStage> stages);

/// `part` of a `whole` that must fit into `room`: unchanged if it fits, else scaled down with the whole.
[[nodiscard]] Duration fitted(Duration part, Duration whole, Duration room);

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

}  // namespace farshade
