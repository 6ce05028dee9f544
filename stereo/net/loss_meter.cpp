#include "stereo/net/loss_meter.h"

#include <algorithm>
#include <cmath>

namespace farshade {

namespace {

constexpr Duration kOutage = std::chrono::milliseconds(250);
constexpr Duration kLossWindow = std::chrono::milliseconds(500);
constexpr Duration kBaseAge = std::chrono::seconds(5);
constexpr double kExcess = 0.10;

}  // namespace

void LossMeter::settle(Time sent) {
  if (run_start_ && counted_to_ - *run_start_ < kOutage) {
    count_ += run_;
    lost_ += run_;
  }
  run_start_.reset();
  run_ = 0;
  counted_to_ = sent;
}

void LossMeter::arrived(Time sent) {
  if (sent < from_) return;
  settle(sent);
  if (!window_start_) window_start_ = sent;
  ++count_;
}

void LossMeter::unreported(Time sent) {
  if (sent < from_) return;
  if (!run_start_) run_start_ = sent;
  counted_to_ = sent;
}

void LossMeter::lost(Time sent) {
  if (sent < from_) return;
  unreported(sent);
  ++run_;
}

std::optional<double> LossMeter::next_window() {
  if (!window_start_ || counted_to_ - *window_start_ < kLossWindow || count_ < kLeastCount)
    return std::nullopt;
  loss_ = static_cast<double>(lost_) / count_;
  if (!base_since_) base_since_ = counted_to_;
  if (counted_to_ - *base_since_ > kBaseAge) {
    base_before_ = base_now_;
    base_now_ = loss_;
    base_since_ = counted_to_;
  }
  base_now_ = std::min(base_now_, loss_);
  window_start_.reset();
  count_ = lost_ = 0;
  return loss_;
}

void LossMeter::restart(Time from) {
  from_ = from;
  window_start_.reset();
  run_start_.reset();
  count_ = lost_ = run_ = 0;
}

bool LossMeter::is_excessive(double loss) const {
  return loss > base() + kExcess + 2 * std::sqrt(base() * (1 - base()) / kLeastCount);
}

}  // namespace farshade
