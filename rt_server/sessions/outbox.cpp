#include "rt_server/sessions/outbox.h"

#include <algorithm>
#include <utility>

#include "rt_server/sessions/job.h"
#include "stereo/base/check.h"

namespace farshade {

void Outbox::put(std::vector<std::vector<std::byte>> messages, Time now, Duration spread) {
  check(empty(), "an outbox takes a frame only when it is empty");
  if (messages.empty()) return;
  messages_ = std::move(messages);
  taken_ = 0;
  for (const std::vector<std::byte>& message : messages_) {
    bytes_ += message.capacity() + kMessage_bytes;
    bytes_left_ += message.size();
  }
  share_ = spread / static_cast<Duration::rep>(messages_.size());
  next_due_ = std::max(now, next_due_);
}

std::optional<Time> Outbox::due() const {
  return empty() ? std::nullopt : std::optional(next_due_);
}

std::vector<std::byte> Outbox::take(double bytes_per_second) {
  check(!empty(), "a message is taken only if there is one");
  check(bytes_per_second > 0, "the rate of a path is positive");
  std::vector<std::byte> message = std::move(messages_[taken_++]);
  bytes_ -= message.capacity() + kMessage_bytes;
  bytes_left_ -= message.size();
  if (empty()) {
    messages_ = {};
    taken_ = 0;
  }
  next_due_ +=
      std::max(share_, duration_from_ms(1e3 * static_cast<double>(message.size()) / bytes_per_second));
  return message;
}

Time Outbox::ends_at(double bytes_per_second) const {
  check(bytes_per_second > 0, "the rate of a path is positive");
  return next_due_ + std::max(share_ * static_cast<Duration::rep>(messages_.size() - taken_),
                              duration_from_ms(1e3 * static_cast<double>(bytes_left_) / bytes_per_second));
}

void Outbox::drop() {
  messages_ = {};
  taken_ = bytes_ = bytes_left_ = 0;
}

}  // namespace farshade
