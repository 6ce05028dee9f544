/// Time: signed 64-bit nanoseconds on a monotonic clock (like XrTime), and an interface for clocks.
/// Programs read time through `Clock`, so that tests can use a clock of their own.
#pragma once

#include <chrono>
#include <cstdint>

namespace farshade {

/// The time base of displays, requests and scenes. Its epoch is arbitrary.
struct StageClock {
  using duration = std::chrono::nanoseconds;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<StageClock, duration>;
  static constexpr bool is_steady = true;
};

using Duration = StageClock::duration;
using Time = StageClock::time_point;

constexpr Time time_from_ns(std::int64_t ns) {
  return Time(Duration(ns));
}
constexpr std::int64_t ns_of(Time time) {
  return time.time_since_epoch().count();
}
constexpr double seconds_of(Duration span) {
  return std::chrono::duration<double>(span).count();
}
constexpr double ms_of(Duration span) {
  return std::chrono::duration<double, std::milli>(span).count();
}
constexpr Duration duration_from_ms(double ms) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double, std::milli>(ms));
}

class Clock {
 public:
  virtual ~Clock() = default;
  [[nodiscard]] virtual Time now() const = 0;
};

/// The machine's steady clock.
class SteadyClock final : public Clock {
 public:
  [[nodiscard]] Time now() const override {
    return Time(std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now().time_since_epoch()));
  }
};

/// Wall time since construction, for the run-time table.
class Stopwatch {
 public:
  [[nodiscard]] Duration elapsed() const { return clock_.now() - start_; }

 private:
  SteadyClock clock_;
  Time start_ = clock_.now();
};

}  // namespace farshade
