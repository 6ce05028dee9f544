#include "stereo/net/delay_trend.h"

#include <algorithm>
#include <cmath>

namespace farshade {

namespace {

// The published constants (draft-ietf-rmcat-gcc-02 and libwebrtc's trendline estimator).
constexpr double kSmoothing = 0.9, kGain = 4, kMostDeltas = 60;
constexpr double kUp = 0.0087, kDown = 0.039, kLeastThreshold = 6, kMostThreshold = 600, kOutlier = 15;
constexpr double kOveruseMs = 10;

constexpr Duration kSilence = std::chrono::milliseconds(500);  ///< the trend restarts after it
constexpr double kJumpMs = 1000;                               ///< a change of delay that no queue causes

}  // namespace

std::uint32_t DelayTrend::group_of(Time sent) {
  const Duration age = sent - sending_since_;
  if (sending_count_ > 0 && (age >= kLongestGroup || (age >= kGroup && sending_count_ >= kGroupCount))) {
    ++sending_;
    sending_count_ = 0;
  }
  if (sending_count_++ == 0) sending_since_ = sent;
  return sending_;
}

void DelayTrend::add(std::uint32_t number, Time sent, double delay_ms) {
  if (number + open_.size() <= newest_) return;
  for (std::uint32_t i = 0; number > newest_ && i < open_.size(); ++i) {
    // From the oldest on: a group is closed when its place in the ring is needed.
    std::optional<Group>& oldest = open_[(newest_ + 1 + i) % open_.size()];
    if (!oldest || oldest->number + open_.size() > number) continue;
    close(*oldest);
    oldest.reset();
  }
  newest_ = std::max(newest_, number);
  std::optional<Group>& group = open_[number % open_.size()];
  if (!group || delay_ms < group->delay_ms) group = {number, sent, delay_ms};
}

void DelayTrend::restart() {
  first_.reset();
  last_.reset();
  points_ = 0;
  over_ = 0;
  over_ms_ = last_trend_ = smoothed_ms_ = 0;
  verdict_ = Verdict::Normal;
}

void DelayTrend::close(const Group& group) {
  if (last_ &&
      (group.sent - last_->sent > kSilence || !(std::abs(group.delay_ms - last_->delay_ms) < kJumpMs)))
    restart();
  if (!first_) first_ = group;
  const double step_ms = last_ ? ms_of(group.sent - last_->sent) : 0;
  const double delay_ms = group.delay_ms - first_->delay_ms;
  smoothed_ms_ = kSmoothing * smoothed_ms_ + (1 - kSmoothing) * delay_ms;
  x_[points_ % kWindow] = ms_of(group.sent - first_->sent) + delay_ms;  // arrival
  y_[points_ % kWindow] = smoothed_ms_;
  ++points_;
  last_ = group;
  if (points_ >= kWindow) detect(slope(), step_ms);
}

double DelayTrend::slope() const {
  double mean_x = 0, mean_y = 0;
  for (std::size_t i = 0; i < kWindow; ++i) {
    mean_x += x_[i] / kWindow;
    mean_y += y_[i] / kWindow;
  }
  double across = 0, along = 0;
  for (std::size_t i = 0; i < kWindow; ++i) {
    across += (x_[i] - mean_x) * (y_[i] - mean_y);
    along += (x_[i] - mean_x) * (x_[i] - mean_x);
  }
  return along > 0 ? across / along : last_trend_;
}

void DelayTrend::detect(double trend, double step_ms) {
  const double scaled = std::min(static_cast<double>(points_), kMostDeltas) * trend * kGain;
  if (scaled > threshold_ms_) {
    over_ms_ += over_ == 0 ? step_ms / 2 : step_ms;
    ++over_;
    if (over_ms_ > kOveruseMs && over_ > 1 && trend >= last_trend_) {
      verdict_ = Verdict::Overuse;
      over_ms_ = 0;
      over_ = 0;
    }
  } else {
    over_ms_ = 0;
    over_ = 0;
    verdict_ = scaled < -threshold_ms_ ? Verdict::Underuse : Verdict::Normal;
  }
  last_trend_ = trend;
  const double size = std::abs(scaled);
  if (size > threshold_ms_ + kOutlier) return;
  threshold_ms_ += (size < threshold_ms_ ? kDown : kUp) * (size - threshold_ms_) * std::min(step_ms, 100.0);
  threshold_ms_ = std::clamp(threshold_ms_, kLeastThreshold, kMostThreshold);
}

}  // namespace farshade
