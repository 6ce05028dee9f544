#include "stereo/net/path_mtu.h"

#include <algorithm>
#include <utility>

#include "stereo/base/check.h"

namespace farshade {

std::optional<std::size_t> PathMtu::next_probe(Time now) {
  if (state_ != State::Searching) {
    if (!search_at_ || now < *search_at_) return std::nullopt;
    search();
  }
  if (probes_sent_ > 0 && now - probed_at_ < kProbeTimer) return std::nullopt;
  if (probes_sent_ < kMostProbes) return kSizes[carried_ + 1];
  state_ = State::Complete;
  search_at_ = now + kRaiseTimer;
  return std::nullopt;
}

void PathMtu::probed(std::uint64_t counter, Time now) {
  check(state_ == State::Searching && probes_sent_ < kMostProbes, "a probe is sent only when one is due");
  probes_[static_cast<std::size_t>(probes_sent_++)] = counter;
  probed_at_ = now;
  remember(counter, kOther);
}

void PathMtu::sent(std::uint64_t counter, std::size_t bytes) {
  check(bytes <= kMaxDatagram_bytes, "a datagram has at most kMaxDatagram_bytes");
  remember(counter, static_cast<std::uint16_t>(bytes));
}

void PathMtu::remember(std::uint64_t counter, std::uint16_t what) {
  check(counter >= next_, "counters of sent datagrams increase");
  if (sent_.empty()) sent_.resize(kRemembered);
  for (std::uint64_t skipped = counter - std::min<std::uint64_t>(counter - next_, kRemembered);
       skipped < counter; ++skipped)
    sent_[skipped % kRemembered] = kOther;
  sent_[counter % kRemembered] = what;
  next_ = counter + 1;
}

void PathMtu::take(const ArrivalReport& report, Time now) {
  const bool arrived = learn(report);
  if (state_ == State::Base && !search_at_ && report.count > 0 && next_ > 0) search_at_ = now;
  if (arrived) {
    ++carried_;
    carried_from_ = next_;
    probes_sent_ = 0;
    if (carried_ + 1 == kSizes.size()) {
      state_ = State::Complete;
      search_at_.reset();
    }
  }
  if (now - marked_at_ >= kLate) {
    settled_to_ = std::exchange(marked_, arrived_to_);
    marked_at_ = now;
  }
  if (carried_ == 0 || !is_black_hole()) return;
  ++black_holes_;
  state_ = State::Base;
  carried_ = 0;
  probes_sent_ = 0;
  search_at_ = now + again_;
  again_ = std::min(2 * again_, kRaiseTimer);
}

/// Returns whether a probe of the size that is tried has arrived.
bool PathMtu::learn(const ArrivalReport& report) {
  const std::span tried = std::span(probes_).first(static_cast<std::size_t>(probes_sent_));
  bool is_probe = false;
  for (std::uint32_t i = 0; i < std::min<std::size_t>(report.count, ArrivalReport::kMost); ++i) {
    const std::uint64_t counter = report.first + i;
    if (!report.arrived(i) || counter >= next_ || next_ - counter > kRemembered) continue;
    is_probe = is_probe || std::ranges::find(tried, counter) != tried.end();
    std::uint16_t& what = sent_[counter % kRemembered];
    if (what != kOther) what |= kArrived;
    arrived_to_ = std::max(arrived_to_, counter + 1);
  }
  return is_probe;
}

void PathMtu::search() {
  state_ = State::Searching;
  search_at_.reset();
  probes_sent_ = 0;
}

/// Looks at the datagrams from the newest that has arrived to the older ones.
bool PathMtu::is_black_hole() const {
  const std::uint64_t oldest = std::max({carried_from_, next_ - std::min<std::uint64_t>(next_, kRemembered),
                                         settled_to_ - std::min<std::uint64_t>(settled_to_, kExamined)});
  std::array<std::uint16_t, kMaxDatagram_bytes + 1> lost{};  // by size, those above the longest arrived one
  std::size_t longest = kBaseDatagram_bytes;
  int arrived = 0, lost_above = 0;
  for (std::uint64_t counter = arrived_to_; counter-- > oldest && lost_above < kLostInBlackHole;) {
    const std::uint16_t what = sent_[counter % kRemembered];
    if (what == kOther) continue;
    const std::size_t bytes = what & ~kArrived;
    if ((what & kArrived) != 0) {
      ++arrived;
      while (longest < bytes) lost_above -= lost[++longest];
    } else if (bytes > longest && arrived >= kArrivedBeyond && counter < settled_to_) {
      ++lost[bytes];
      ++lost_above;
    }
  }
  return lost_above == kLostInBlackHole;
}

}  // namespace farshade
