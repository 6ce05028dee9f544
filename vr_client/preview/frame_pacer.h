/// FramePacer: which display times frames are made for. Display times lie on the display's grid. A frame
/// begins on a grid point and is shown n points later; the next begins when it is shown. n follows how long
/// frames take, as headset runtimes throttle an application to a half or third of the refresh rate, so that
/// the frame interval that predictors see is the true one.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "vr_client/runtime/runtime.h"

namespace farshade {

class FramePacer {
 public:
  /// n rises when this quantile of the last kRemembered frame times exceeds n display periods: one frame in
  /// five may hitch without a change. It falls to m when that quantile is within kRoom of m periods.
  static constexpr std::size_t kRemembered = 16;
  static constexpr double kQuantile = 0.75, kRoom = 0.9;

  /// `refresh_hz` > 0. Starts with n = 1.
  explicit FramePacer(double refresh_hz);

  /// The frame begun last took so long to make.
  void learn(Duration frame_time);

  /// When the next frame should begin: `now` for the first; else when the last is shown, or, more than half a
  /// period too late for that, at the next grid point. May lie less than half a period before `now`.
  [[nodiscard]] Time next_begin(Time now) const;

  /// A frame begins now. Its display time is later than every one before it, by whole display periods.
  [[nodiscard]] FrameTiming begin(Time now);

  /// n: display periods that a frame begun now is given.
  [[nodiscard]] std::uint32_t periods() const { return periods_; }

 private:
  [[nodiscard]] Duration after(std::int64_t ticks) const;
  [[nodiscard]] std::int64_t tick_to_begin_at(Time now) const;

  double period_ns_;
  std::uint32_t periods_ = 1;
  std::array<double, kRemembered> frame_times_ns_;
  std::size_t oldest_ = 0;
  std::optional<Time> grid_;   ///< grid point 0: when the first frame began
  std::int64_t shown_at_ = 0;  ///< grid point at which the last frame is shown
};

}  // namespace farshade
