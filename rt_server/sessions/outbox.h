/// Outbox: sends the datagrams of one frame evenly over a part of the frame interval, and never faster than
/// the path takes them at the moment. The session's next frame is traced when its outbox is empty and the
/// path has drained. So a slow path lowers the mask rate and does not build a queue. It holds only what is
/// not yet sent.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "stereo/base/clock.h"

namespace farshade {

class Outbox {
 public:
  /// Takes the messages of one frame. The outbox must be empty. The first message is due at `now`, or at
  /// drained_at() if that is later; the others follow at least an equal share of `spread` apart.
  void put(std::vector<std::vector<std::byte>> messages, Time now, Duration spread);

  /// When the next message is due; nothing if the outbox is empty.
  [[nodiscard]] std::optional<Time> due() const;

  /// Removes the next message. The outbox must not be empty. The message after it is due when the path has
  /// taken this one at `bytes_per_second` (> 0), the rate of now, or after the share if that is longer. It
  /// does not matter when take() is called: after a delay several are due.
  [[nodiscard]] std::vector<std::byte> take(double bytes_per_second);

  [[nodiscard]] bool empty() const { return taken_ == messages_.size(); }
  /// Memory of the messages that are not yet sent.
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

  /// When the path has taken all messages, if it goes on with `bytes_per_second` (> 0).
  [[nodiscard]] Time ends_at(double bytes_per_second) const;

  /// Removes the messages that are left.
  void drop();

  /// When the path has taken all messages that were taken from here, at the rates of then. The clock's zero
  /// before the first put().
  [[nodiscard]] Time drained_at() const { return next_due_; }

 private:
  std::vector<std::vector<std::byte>> messages_;  ///< of one frame; those taken are empty
  std::size_t taken_ = 0, bytes_ = 0;
  std::size_t bytes_left_ = 0;  ///< total size of those not taken
  Duration share_{};
  Time next_due_{};
};

}  // namespace farshade
