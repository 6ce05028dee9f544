/// Player: which instant of a recording is on show, as the session's time goes on.
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

  /// At the end, starts over.
  void play();
  void pause() { playing_ = false; }
  /// To this time after the recording's start, or to the end that is nearer. Plays on if it played.
  void scrub(Duration to);
  /// Recorded seconds a second, held within kSlowest..kFastest.
  void set_speed(double speed);
  void set_at_end(AtEnd at_end) { at_end_ = at_end; }

  /// The session's time has moved on by `span` >= 0. With AtEnd::Hold, reaching the end pauses there; with
  /// Loop the end is the beginning.
  void advance(Duration span);

  /// Since the recording's start: 0..length.
  [[nodiscard]] Duration position() const { return position_; }
  /// Where `advance(ahead)` would lead. A negative span leads back.
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
