#include "stereo/net/arrivals.h"

namespace farshade {

void Arrivals::add(std::uint64_t counter, Time arrived) {
  if (received_ == 0) newest_ = counter;
  // The counters that it skipped are new as well: they may be lost.
  const std::uint64_t new_from = counter > newest_ ? newest_ + 1 : counter;
  ++received_;
  oldest_ = std::min(oldest_, counter);
  if (counter > newest_) {
    const std::uint64_t step = std::min<std::uint64_t>(counter - newest_, kKept);
    for (std::uint64_t i = 0; i < step; ++i) slots_[(counter - i) % kKept].has_arrived = false;
    newest_ = counter;
  }
  if (newest_ - counter >= kKept) return;
  slots_[counter % kKept] = {true, arrived};
  fresh_from_[0] = std::min(fresh_from_[0], new_from);
}

std::uint64_t Arrivals::missing() const {
  return received_ == 0 ? 0 : newest_ - oldest_ + 1 - received_;
}

std::uint64_t Arrivals::oldest_to_report() const {
  const std::uint64_t oldest = *std::min_element(fresh_from_.begin(), fresh_from_.end());
  return newest_ >= kKept && oldest != kNothing ? std::max(oldest, newest_ - kKept + 1) : oldest;
}

ArrivalReport Arrivals::report() {
  std::uint64_t first = oldest_to_report();
  std::rotate(fresh_from_.rbegin(), fresh_from_.rbegin() + 1, fresh_from_.rend());
  fresh_from_[0] = kNothing;
  ArrivalReport report;
  if (first == kNothing) return report;

  Time latest = Time::min();
  for (std::uint64_t counter = first; counter <= newest_; ++counter)
    if (slot(counter).has_arrived) latest = std::max(latest, slot(counter).arrived);
  // The ticks cannot express an arrival too long before the latest one. Earlier reports contained it.
  const Time earliest = latest - (ArrivalReport::kNotArrived - 1) * ArrivalReport::kTick;
  report.base = latest;
  for (std::uint64_t counter = newest_ + 1; counter-- > first;) {
    if (!slot(counter).has_arrived) continue;
    if (slot(counter).arrived < earliest) {
      first = counter + 1;
      break;
    }
    report.base = std::min(report.base, slot(counter).arrived);
  }

  report.first = first;
  report.count = static_cast<std::uint32_t>(newest_ - first + 1);
  for (std::uint32_t i = 0; i < report.count; ++i) {
    const Slot& entry = slot(first + i);
    report.ticks[i] = entry.has_arrived
                          ? static_cast<std::uint16_t>((entry.arrived - report.base) / ArrivalReport::kTick)
                          : ArrivalReport::kNotArrived;
  }
  return report;
}

}  // namespace farshade
