#include "stereo/base/failure_log.h"

#include <utility>

namespace farshade {

std::optional<std::string> FailureLog::failed(const std::string& what, Time now) {
  if (logged_at_ && now - *logged_at_ < kInterval) {
    ++not_logged_;
    return std::nullopt;
  }
  logged_at_ = now;
  const std::uint64_t others = std::exchange(not_logged_, 0);
  return others == 0 ? what : what + " (" + std::to_string(others) + " more failures since the last line)";
}

}  // namespace farshade
