/// Outbox: sends the datagrams of one frame evenly over the frame interval, and never faster than the path
/// takes them. The session's next frame is traced when its outbox is empty and the path has drained. So a
/// slow path lowers the mask rate and does not build a queue. A value; the caller passes the time. Memory is
/// reused.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "stereo/base/clock.h"

namespace farshade {

class Outbox {
 public:
  /// Copies the messages of one frame. The outbox must be empty. The first message is due at `now`, or at
  /// drained_at() if that is later. The time to the next message is an equal share of `spread`, or the time
  /// that sending the message takes at `bytes_per_second` (> 0) if that is longer.
  void put(std::span<const std::vector<std::byte>> messages, Time now, Duration spread,
           double bytes_per_second);

  /// When the next message is due; nothing if the outbox is empty.
  [[nodiscard]] std::optional<Time> due() const;

  /// Removes the next message. The outbox must not be empty. The span is valid until put(). Due times are
  /// fixed: after a delay several messages are due.
  std::span<const std::byte> take();

  [[nodiscard]] bool empty() const { return taken_ == count_; }

  /// When the path has taken all messages, at the given rates. The clock's zero before the first put().
  [[nodiscard]] Time drained_at() const { return drained_at_; }

 private:
  struct Message {
    std::vector<std::byte> bytes;
    Time due{};
  };

  std::vector<Message> messages_;  ///< the first count_ belong to this frame
  std::size_t count_ = 0, taken_ = 0;
  Time drained_at_{};
};

}  // namespace farshade
