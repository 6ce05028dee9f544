#include "rt_server/core/outbox.h"

#include <algorithm>

#include "stereo/base/check.h"

namespace farshade {

void Outbox::put(std::span<const std::vector<std::byte>> messages, Time now, Duration spread,
                 double bytes_per_second) {
  check(empty(), "an outbox takes a frame only when it is empty");
  check(bytes_per_second > 0, "the rate of a path is positive");
  if (messages.empty()) return;
  if (messages_.size() < messages.size()) messages_.resize(messages.size());
  count_ = messages.size();
  taken_ = 0;
  const Duration share = spread / static_cast<Duration::rep>(messages.size());
  Time due = std::max(now, drained_at_);
  for (std::size_t i = 0; i < messages.size(); ++i) {
    messages_[i].bytes.assign(messages[i].begin(), messages[i].end());
    messages_[i].due = due;
    const double sending_ms = 1e3 * static_cast<double>(messages[i].size()) / bytes_per_second;
    due += std::max(share, duration_from_ms(sending_ms));
  }
  drained_at_ = due;
}

std::optional<Time> Outbox::due() const {
  return empty() ? std::nullopt : std::optional(messages_[taken_].due);
}

std::span<const std::byte> Outbox::take() {
  check(!empty(), "a message is taken only if there is one");
  return messages_[taken_++].bytes;
}

}  // namespace farshade
