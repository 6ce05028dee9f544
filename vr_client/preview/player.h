/// Player: the position within a head recording while it plays.
#pragma once

#include <cstdint>

#include "stereo/base/clock.h"

namespace farshade {

enum class AtEnd : std::uint8_t { Hold, Loop };

class Player {
 public:
  static constexpr double kSlowest = 0.1, kFastest = 4.0;

  /// Plays from the beginning. `length` > 0.
  explicit Player(Duration length);

  /// At the end of the recording, plays from the beginning.
  void play();
  void pause() { playing_ = false; }
  /// Moves to this time since the start of the recording, clamped to its length. Does not change playing().
  void scrub(Duration to);
  /// Recorded seconds per second, clamped to kSlowest..kFastest.
  void set_speed(double speed);
  void set_at_end(AtEnd at_end) { at_end_ = at_end; }

  /// Advances by `span` >= 0 of display time. At the end, AtEnd::Hold pauses, and AtEnd::Loop continues from
  /// the beginning.
  void advance(Duration span);

  /// Time since the start of the recording: 0..length.
  [[nodiscard]] Duration position() const { return position_; }
  /// The position after `advance(ahead)`. A negative span gives an earlier position.
  [[nodiscard]] Duration position_after(Duration ahead) const;
  [[nodiscard]] Duration length() const { return length_; }
  [[nodiscard]] bool playing() const { return playing_; }
  [[nodiscard]] double speed() const { return speed_; }
  [[nodiscard]] AtEnd at_end() const { return at_end_; }

 private:
  Duration length_;
  Duration position_{};
  bool playing_ = true;
  double speed_ = 1.0;
  AtEnd at_end_ = AtEnd::Hold;
};

}  // namespace farshade
