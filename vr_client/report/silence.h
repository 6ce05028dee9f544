/// Silence: when the server answers nothing. It says so once, and once when answers come again, and counts
/// the frames and the time in between, which belong into no run-time figure.
#pragma once

#include <optional>
#include <string>

#include "vr_client/frame/frame_loop.h"

namespace farshade {

class Silence {
 public:
  /// `server` is its address, for the sentences. `known` : the user knows already that it does not answer.
  explicit Silence(std::string server, bool known = false) : server_(std::move(server)), told_(known) {}

  /// Adds a frame that was shown at `now`. `since` is when the server fell silent; no value while it answers.
  /// `why`: the server said so itself. Returns what to tell the user.
  [[nodiscard]] std::optional<std::string> add(FrameId frame, std::optional<Time> since, Time now,
                                               const std::optional<std::string>& why = {});

  [[nodiscard]] std::uint32_t frames() const { return frames_; }
  /// The time that the server has been silent, all times together.
  [[nodiscard]] Duration time() const { return before_ + (since_ ? last_ - *since_ : Duration::zero()); }

 private:
  std::string server_;
  bool told_;
  std::optional<Time> since_;  ///< the present silence
  Time last_{};                ///< of the last frame
  Duration before_{};          ///< of earlier silences
  std::uint32_t frames_ = 0, frames_now_ = 0;
};

}  // namespace farshade
