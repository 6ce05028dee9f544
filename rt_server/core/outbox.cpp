#include "rt_server/core/outbox.h"

#include <algorithm>

#include "stereo/base/check.h"

namespace farshade {

void Outbox::put(std::span<const std::vector<std::byte>> messages, Time now, Duration spread,
                 double bytes_per_second) {
  check(empty(), "an outbox takes a frame when the last has left");
  check(bytes_per_second > 0, "a path takes some bytes a second");
  if (messages.empty()) return;
  if (messages_.size() < messages.size()) messages_.resize(messages.size());
  count_ = messages.size();
  taken_ = 0;
  const Duration share = spread / static_cast<Duration::rep>(messages.size());
  Time due = std::max(now, drained_at_);
  for (std::size_t i = 0; i < messages.size(); ++i) {
    messages_[i].bytes.assign(messages[i].begin(), messages[i].end());
    messages_[i].due = due;
    const double swallowed_ms = 1e3 * static_cast<double>(messages[i].size()) / bytes_per_second;
    due += std::max(share, duration_from_ms(swallowed_ms));
  }
  drained_at_ = due;
}

std::optional<Time> Outbox::due() const {
  return empty() ? std::nullopt : std::optional(messages_[taken_].due);
}

std::span<const std::byte> Outbox::take() {
  check(!empty(), "who takes from an outbox has asked whether it is empty");
  return messages_[taken_++].bytes;
}

}  // namespace farshade
