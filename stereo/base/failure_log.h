/// FailureLog: limits the log of failures that may repeat with every frame or datagram: at most one line per
/// interval.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "stereo/base/clock.h"

namespace farshade {

class FailureLog {
 public:
  static constexpr Duration kInterval = std::chrono::seconds(10);

  /// Counts a failure. Returns the line to log: for the first failure, and for the first one that comes at
  /// least kInterval after the last line; then with the number of failures in between.
  [[nodiscard]] std::optional<std::string> failed(const std::string& what, Time now);

 private:
  std::optional<Time> logged_at_;
  std::uint64_t not_logged_ = 0;
};

}  // namespace farshade
