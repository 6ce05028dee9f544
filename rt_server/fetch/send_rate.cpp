#include "rt_server/fetch/send_rate.h"

#include <algorithm>

namespace farshade {

Duration SendRate::take(std::size_t bytes, Masks masks, Time now) {
  free_at_ = std::max(free_at_, now);
  if (free_at_ - now > kMostAhead) return free_at_ - now - kMostAhead;
  const double rate = full_ * (masks == Masks::Sent ? kBesideMasks : 1);
  free_at_ += duration_from_ms(static_cast<double>(bytes) / rate * 1e3);
  return Duration::zero();
}

}  // namespace farshade
