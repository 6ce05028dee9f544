#include "rt_server/scheduling/quality.h"

#include <cmath>

#include "stereo/base/check.h"

namespace farshade {

namespace {

constexpr double kMostIntervals = 4;  ///< intervals that sending a frame may take at the current size
constexpr double kLargerIntervals = 0.6 * kMostIntervals;  ///< the same at the next larger size
constexpr double kNewestWeight = 0.2;                      ///< of a frame in the mean of bytes per frame

/// Bytes at a scale, as a share of the bytes at full size.
double bytes_share(ViewScale scale) {
  return std::pow(factor_of(scale), 1.5);
}

}  // namespace

double Quality::bytes_at(ViewScale scale) const {
  return *full_bytes_ * bytes_share(scale);
}

Quality::Change Quality::change_for(double bytes_per_second, Duration interval) const {
  const double bytes_per_interval = bytes_per_second * seconds_of(interval);
  if (scale_ > kLeast && bytes_at(scale_) > kMostIntervals * bytes_per_interval) return Change::Smaller;
  if (scale_ < kFullViewScale && bytes_at({scale_.eighths + 1}) < kLargerIntervals * bytes_per_interval)
    return Change::Larger;
  return Change::None;
}

void Quality::packed(std::size_t bytes, ViewScale scale, double bytes_per_second, Duration interval,
                     Time now) {
  check(scale >= kLeast && scale <= kFullViewScale, "a frame's scale is one that was advised");
  check(bytes_per_second > 0, "the rate of a path is positive");
  const double full = static_cast<double>(bytes) / bytes_share(scale);
  full_bytes_ = full_bytes_ ? *full_bytes_ + kNewestWeight * (full - *full_bytes_) : full;

  const Change change = change_for(bytes_per_second, interval);
  if (change != change_) {
    change_ = change;
    change_since_ = now;
  }
  if (change_ == Change::None || now - change_since_ < kDwell) return;
  if (change_ == Change::Smaller) --scale_.eighths;
  if (change_ == Change::Larger) ++scale_.eighths;
  change_ = Change::None;
}

void Quality::was_too_costly(Time now) {
  if (scale_ > kLeast) --scale_.eighths;
  change_ = Change::None;
  change_since_ = now;
}

}  // namespace farshade
