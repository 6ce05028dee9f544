#include "stereo/net/rate_control.h"

#include <algorithm>
#include <cmath>

#include "stereo/base/check.h"

namespace farshade {

namespace {

// The published constants (draft-ietf-rmcat-gcc-02).
constexpr double kDecrease = 0.85, kIncrease = 1.08, kBeyondCarried = 1.5;

constexpr Duration kLate =
    std::chrono::milliseconds(250);  ///< a datagram is lost if one came that was sent this much later
/// Reports that know of no arrival lower the rate after this time: longer than the outages of a radio link.
constexpr Duration kUnheard = std::chrono::milliseconds(500);
constexpr Duration kHalving =
    std::chrono::milliseconds(125);  ///< so that a second after the last news it is 1/16
/// Client times beyond this are invalid; sums with them could overflow.
constexpr std::int64_t kMostNs = std::int64_t{1} << 61;

}  // namespace

RateControl::RateControl(RateLimits limits)
    : limits_(limits), rate_(std::clamp(kStart, limits.least, limits.most)) {}

void RateControl::limit(const RateLimits& limits) {
  limits_ = limits;
  rate_ = std::clamp(rate_, limits.least, limits.most);
}

void RateControl::sent(std::uint64_t counter, std::size_t bytes, Time at) {
  record(counter, {at, trend_.group_of(at), narrow<std::uint16_t>(bytes), Outcome::Unreported});
  allowed_bytes_ = std::max<std::int64_t>(0, allowed_bytes_ - static_cast<std::int64_t>(bytes));
  if (!unheard_since_) unheard_since_ = at;
}

void RateControl::sent_elsewhere(std::uint64_t counter, Time at) {
  record(counter, {.at = at, .outcome = Outcome::Elsewhere});
}

void RateControl::skipped(std::uint64_t counter, Time at) {
  record(counter, {.at = at, .outcome = Outcome::Skipped});
}

void RateControl::record(std::uint64_t counter, const Record& sent) {
  if (next_ == oldest_) next_ = oldest_ = judged_ = counter;
  check_eq(counter, next_, "counters of sent datagrams go up by one");
  if (records_.empty()) records_.resize(kRemembered);
  records_[counter % kRemembered] = sent;
  ++next_;
  if (next_ - oldest_ > kRemembered) ++oldest_;
}

double RateControl::sending_bytes_per_second() const {
  const bool is_slow = ramp_left_bytes_ > 0 && allowed_bytes_ <= 0;
  const double rate = is_slow ? std::min(rate_, std::max(limits_.least, kSlow)) : rate_;
  if (unheard_ <= kUnheard) return rate;
  return std::max(limits_.least, rate * std::exp2(-seconds_of(unheard_ - kUnheard) / seconds_of(kHalving)));
}

RateControl::Record* RateControl::find(std::uint64_t counter) {
  return counter >= oldest_ && counter < next_ ? &records_[counter % kRemembered] : nullptr;
}

void RateControl::take(const ArrivalReport& report, Time now) {
  if (!learn(report, now)) {
    unheard_ = unheard_since_ ? now - *unheard_since_ : Duration{};
    return;
  }
  unheard_since_.reset();
  unheard_ = {};
  if (got_false_report_) return;
  judge_losses();
  adapt_to_loss(now);
  adapt_to_delay(now);
  adapted_ = now;
}

/// Returns whether anything in the report was new.
bool RateControl::learn(const ArrivalReport& report, Time now) {
  if (report.count > ArrivalReport::kMost || report.first > next_ ||
      std::abs(ns_of(report.base) / 2) > kMostNs / 2)
    return false;
  std::optional<Time> newest;
  for (std::uint32_t i = 0; i < report.count; ++i) {
    Record* record = find(report.first + i);
    if (record == nullptr || record->outcome == Outcome::Arrived || record->outcome == Outcome::Elsewhere)
      continue;
    if (record->outcome == Outcome::Skipped) {
      if (report.arrived(i)) distrust();
      continue;
    }
    record->outcome = report.arrived(i) ? Outcome::Arrived : Outcome::Absent;
    if (record->outcome == Outcome::Absent) continue;
    const Time arrival = report.arrival(i);
    trend_.add(record->group, record->at,
               (static_cast<double>(ns_of(arrival)) - static_cast<double>(ns_of(record->at))) * 1e-6);
    received_.add(arrival, record->bytes);
    allowed_bytes_ += std::int64_t{2} * record->bytes;
    ramp_left_bytes_ -= record->bytes;
    newest = record->at;
  }
  if (!newest) return false;
  newest_arrived_ = std::max(newest_arrived_, *newest);
  round_trip_ = std::clamp<Duration>(now - *newest, std::chrono::milliseconds(10), std::chrono::seconds(1));
  return true;
}

void RateControl::distrust() {
  got_false_report_ = true;
  rate_ = limits_.least;
}

/// Counts datagrams that were sent kLate or more before the newest arrival: they will not arrive any more.
void RateControl::judge_losses() {
  judged_ = std::max(judged_, oldest_);
  for (; judged_ < next_; ++judged_) {
    const Record& record = *find(judged_);
    if (newest_arrived_ - record.at < kLate) break;
    if (record.outcome == Outcome::Arrived) losses_.arrived(record.at);
    if (record.outcome == Outcome::Absent) losses_.lost(record.at);
    if (record.outcome == Outcome::Unreported) losses_.unreported(record.at);
  }
}

std::optional<double> RateControl::carried() const {
  const auto received = received_.bytes_per_second();
  if (!received) return std::nullopt;
  return *received / (1 - std::min(losses_.base(), 0.5));
}

void RateControl::adapt_to_delay(Time now) {
  const double seconds = adapted_ ? std::min(seconds_of(now - *adapted_), 0.5) : 0;
  if (trend_.verdict() == DelayTrend::Verdict::Normal) raise(seconds);
  if (trend_.verdict() != DelayTrend::Verdict::Overuse) return;
  // The effect of a lower rate is visible one round trip later.
  if (lowered_ && now - *lowered_ < std::max<Duration>(round_trip_, std::chrono::milliseconds(100))) return;
  lower_to(kDecrease * carried().value_or(rate_), now);
  if (trial_) trial_->rate_before = std::min(trial_->rate_before, rate_);
}

/// The loss guard: lowers the rate once after excessive loss. If the loss remains at the lower rate, it
/// belongs to the path: it becomes the base loss, and the rate is restored.
void RateControl::adapt_to_loss(Time now) {
  const auto loss = losses_.next_window();
  if (!loss) return;
  excessive_ = losses_.is_excessive(*loss) ? excessive_ + 1 : 0;
  if (excessive_ == 0) {
    trial_.reset();
  } else if (trial_ && *loss > 0.75 * trial_->loss_before) {
    losses_.set_base(*loss);
    rate_ = std::max(rate_, trial_->rate_before);
    capacity_.reset();
    trial_.reset();
  } else if (trial_ || excessive_ > 1) {
    trial_ = Trial{rate_, *loss};
    lower_to(kDecrease * received_.bytes_per_second().value_or(rate_), now);
    losses_.restart(now);
  }
}

/// As published: slow growth near the rate of the last decrease, fast growth elsewhere, and never far above
/// the received rate. The paper's step is for one second. Here it is for one response time: with steps of a
/// second it takes 23 s from 2 Mbit/s to the rate that 72 Hz needs.
void RateControl::raise(double seconds) {
  if (trial_) return;
  const auto carried_now = carried();
  if (!carried_now) return;
  if (capacity_ && *carried_now > 1.1 * *capacity_) capacity_.reset();
  const double response = seconds_of(round_trip_) + 0.1;
  const bool near = capacity_ && rate_ > 0.9 * *capacity_;
  const double raised = rate_ * std::pow(kIncrease, near ? seconds : seconds / response);
  rate_ = std::clamp(std::min(raised, std::max(rate_, kBeyondCarried * *carried_now)), limits_.least,
                     limits_.most);
}

void RateControl::lower_to(double bytes_per_second, Time now) {
  capacity_ = carried();
  rate_ = std::clamp(std::min(rate_, bytes_per_second), limits_.least, limits_.most);
  lowered_ = now;
}

}  // namespace farshade
