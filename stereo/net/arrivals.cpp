#include "stereo/net/arrivals.h"

namespace farshade {

void Arrivals::add(std::uint64_t counter, Time arrived) {
  if (received_ == 0) newest_ = counter;
  // What was skipped is news too: it may be lost.
  const std::uint64_t news_from = counter > newest_ ? newest_ + 1 : counter;
  ++received_;
  oldest_ = std::min(oldest_, counter);
  if (counter > newest_) {
    const std::uint64_t step = std::min<std::uint64_t>(counter - newest_, kKept);
    for (std::uint64_t i = 0; i < step; ++i) slots_[(counter - i) % kKept].here = false;
    newest_ = counter;
  }
  if (newest_ - counter >= kKept) return;
  slots_[counter % kKept] = {true, arrived};
  fresh_from_[0] = std::min(fresh_from_[0], news_from);
}

std::uint64_t Arrivals::missing() const {
  return received_ == 0 ? 0 : newest_ - oldest_ + 1 - received_;
}

std::uint64_t Arrivals::oldest_to_tell() const {
  const std::uint64_t oldest = *std::min_element(fresh_from_.begin(), fresh_from_.end());
  return newest_ >= kKept && oldest != kNothing ? std::max(oldest, newest_ - kKept + 1) : oldest;
}

ArrivalReport Arrivals::report() {
  std::uint64_t first = oldest_to_tell();
  std::rotate(fresh_from_.rbegin(), fresh_from_.rbegin() + 1, fresh_from_.rend());
  fresh_from_[0] = kNothing;
  ArrivalReport told;
  if (first == kNothing) return told;

  Time latest = Time::min();
  for (std::uint64_t counter = first; counter <= newest_; ++counter)
    if (slot(counter).here) latest = std::max(latest, slot(counter).arrived);
  // What came too long before the latest cannot be said with it; it was said while it was new.
  const Time earliest = latest - (ArrivalReport::kNotArrived - 1) * ArrivalReport::kTick;
  told.base = latest;
  for (std::uint64_t counter = newest_ + 1; counter-- > first;) {
    if (!slot(counter).here) continue;
    if (slot(counter).arrived < earliest) {
      first = counter + 1;
      break;
    }
    told.base = std::min(told.base, slot(counter).arrived);
  }

  told.first = first;
  told.count = static_cast<std::uint32_t>(newest_ - first + 1);
  for (std::uint32_t i = 0; i < told.count; ++i) {
    const Slot& entry = slot(first + i);
    told.ticks[i] = entry.here
                        ? static_cast<std::uint16_t>((entry.arrived - told.base) / ArrivalReport::kTick)
                        : ArrivalReport::kNotArrived;
  }
  return told;
}

}  // namespace farshade
