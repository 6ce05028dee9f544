#include "rt_server/core/quality.h"

#include <cmath>

#include "stereo/base/check.h"

namespace farshade {

namespace {

constexpr double kMostIntervals = 4;  ///< a frame may take before it is made smaller
constexpr double kMarginUp = 0.6;     ///< of them, for the larger size
constexpr double kNewest = 0.2;       ///< weight of a frame's bytes in their mean

/// Bytes at a scale, as a share of those at full size.
double share_of(std::uint32_t scale) {
  return std::pow(static_cast<double>(scale) / Quality::kFull, 1.5);
}

}  // namespace

double Quality::bytes_at(std::uint32_t scale) const {
  return *full_bytes_ * share_of(scale);
}

Quality::Wish Quality::wish(double bytes_per_second, Duration interval) const {
  const double carried = bytes_per_second * seconds_of(interval) * kMostIntervals;  // bytes in four intervals
  if (scale_ > kLeast && bytes_at(scale_) > carried) return Wish::Smaller;
  if (scale_ < kFull && bytes_at(scale_ + 1) < kMarginUp * carried) return Wish::Larger;
  return Wish::Stay;
}

void Quality::packed(std::size_t bytes, std::uint32_t scale_eighths, double bytes_per_second,
                     Duration interval, Time now) {
  check(scale_eighths >= kLeast && scale_eighths <= kFull, "a frame's scale is one that was advised");
  check(bytes_per_second > 0, "a path takes some bytes a second");
  const double full = static_cast<double>(bytes) / share_of(scale_eighths);
  full_bytes_ = full_bytes_ ? *full_bytes_ + kNewest * (full - *full_bytes_) : full;

  const Wish wished = wish(bytes_per_second, interval);
  if (wished != wish_) {
    wish_ = wished;
    wished_since_ = now;
  }
  if (wish_ == Wish::Stay || now - wished_since_ < kDwell) return;
  if (wish_ == Wish::Smaller) --scale_;
  if (wish_ == Wish::Larger) ++scale_;
  wish_ = Wish::Stay;
}

}  // namespace farshade
