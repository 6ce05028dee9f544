/// Outbox: one frame's datagrams on their way out, evenly over the frame interval and never faster than the
/// path takes them. A session's next frame is traced when its outbox is empty and the path has drained, so a
/// slow path lowers the mask rate and builds no queue. A value; time is passed in; memory is used again.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "stereo/base/clock.h"

namespace farshade {

class Outbox {
 public:
  /// Takes one frame's messages, as copies. The first leaves at `now`, or when the path has swallowed what
  /// left before; each gives the next its share of `spread`, or the time that `bytes_per_second` (> 0) takes
  /// for it if that is longer. The outbox must be empty.
  void put(std::span<const std::vector<std::byte>> messages, Time now, Duration spread,
           double bytes_per_second);

  /// When the next may leave; none when empty.
  [[nodiscard]] std::optional<Time> due() const;

  /// The next message; not when empty. Valid until put(). The timetable stays: who comes late finds several
  /// due.
  std::span<const std::byte> take();

  [[nodiscard]] bool empty() const { return taken_ == count_; }

  /// When the path is expected to have swallowed all that was put; the clock's zero before anything was.
  [[nodiscard]] Time drained_at() const { return drained_at_; }

 private:
  struct Message {
    std::vector<std::byte> bytes;
    Time due{};
  };

  std::vector<Message> messages_;  ///< of which `count_` are of this frame
  std::size_t count_ = 0, taken_ = 0;
  Time drained_at_{};
};

}  // namespace farshade
