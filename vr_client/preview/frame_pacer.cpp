#include "vr_client/preview/frame_pacer.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "stereo/base/check.h"
#include "stereo/base/quantile.h"

namespace farshade {

FramePacer::FramePacer(double refresh_hz) : period_ns_(1e9 / refresh_hz) {
  check(std::isfinite(refresh_hz) && refresh_hz > 0, "the refresh rate is finite and above 0");
  // The first frame is often slow. With 15 frame times of 0 beside it, it does not change the pace.
  frame_times_ns_.fill(0.0);
}

void FramePacer::learn(Duration frame_time) {
  frame_times_ns_[oldest_] = static_cast<double>(frame_time.count());
  oldest_ = (oldest_ + 1) % kRemembered;
  const double typical = quantile({frame_times_ns_.begin(), frame_times_ns_.end()}, kQuantile) / period_ns_;
  const auto fits = static_cast<std::uint32_t>(std::max(1.0, std::ceil(typical)));
  const auto fits_with_room = static_cast<std::uint32_t>(std::max(1.0, std::ceil(typical / kRoom)));
  periods_ = std::clamp(periods_, fits, fits_with_room);
}

Time FramePacer::next_begin(Time now) const {
  return grid_ ? *grid_ + after(tick_to_begin_at(now)) : now;
}

FrameTiming FramePacer::begin(Time now) {
  if (!grid_) grid_ = now;
  shown_at_ = tick_to_begin_at(now) + periods_;
  return {*grid_ + after(shown_at_), after(periods_)};
}

Duration FramePacer::after(std::int64_t ticks) const {
  return Duration(std::llround(static_cast<double>(ticks) * period_ns_));
}

std::int64_t FramePacer::tick_to_begin_at(Time now) const {
  return std::max<std::int64_t>(shown_at_,
                                std::llround(static_cast<double>((now - *grid_).count()) / period_ns_));
}

}  // namespace farshade
