#include "vr_client/report/silence.h"

#include <fmt/format.h>

namespace farshade {

std::optional<std::string> Silence::add(FrameId frame, std::optional<Time> since, Time now,
                                        const std::optional<std::string>& why) {
  if (since) {
    last_ = now;
    ++frames_;
    ++frames_now_;
    if (!since_) since_ = since;
    if (std::exchange(told_, true)) return std::nullopt;
    if (why)
      return fmt::format("frame {}: {}. The client goes on with the last masks and keeps trying", frame.value,
                         *why);
    return fmt::format(
        "frame {}: the server at {} has sent nothing for {:.1f} s. Is rt_server still running there? The "
        "client "
        "goes on with the last masks and keeps trying",
        frame.value, server_, seconds_of(now - *since));
  }
  told_ = false;
  if (!since_) return std::nullopt;
  before_ += now - *since_;
  const std::string text = fmt::format(
      "frame {}: the server at {} answers after {:.1f} s; {} frames were shown "
      "meanwhile",
      frame.value, server_, seconds_of(now - *since_), frames_now_);
  since_.reset();
  frames_now_ = 0;
  return text;
}

}  // namespace farshade
