/// FramePacer: chooses the display time of each frame on the grid of the display's refreshes. A frame begins
/// on a grid point and is shown n points later; the next frame begins when it is shown. n follows the
/// measured frame times, as headset runtimes throttle an application to a half or a third of the refresh
/// rate. So predictors see the true frame interval.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "vr_client/runtime/runtime.h"

namespace farshade {

class FramePacer {
 public:
  /// n rises if this quantile of the last kRemembered frame times exceeds n display periods, so that one late
  /// frame in five does not change it. n falls to m if the quantile is below kRoom * m periods.
  static constexpr std::size_t kRemembered = 16;
  static constexpr double kQuantile = 0.75, kRoom = 0.9;

  /// `refresh_hz` > 0. Starts with n = 1.
  explicit FramePacer(double refresh_hz);

  /// Adds the frame time of the last frame.
  void learn(Duration frame_time);

  /// When the next frame should begin. The first frame begins at `now`. Later frames begin when the last one
  /// is shown or, if that is more than half a period ago, at the nearest grid point. The result may lie up to
  /// half a period before `now`.
  [[nodiscard]] Time next_begin(Time now) const;

  /// Begins a frame at `now`. Its display time is later than all earlier ones, by whole display periods.
  [[nodiscard]] FrameTiming begin(Time now);

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
