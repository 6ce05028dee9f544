/// FailureLog: limits the log of failures that may repeat with every frame or datagram: at most one line per
/// interval. FailureLogs: a FailureLog for each source.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
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

/// A FailureLog for each source, for example each client. Sources come and go.
template <class Source>
class FailureLogs {
 public:
  /// Forgets all sources when there would be more than `most`.
  explicit FailureLogs(std::size_t most) : most_(most) {}

  /// See FailureLog::failed().
  [[nodiscard]] std::optional<std::string> failed(const Source& source, const std::string& what, Time now) {
    if (logs_.size() >= most_ && !logs_.contains(source)) logs_.clear();
    return logs_[source].failed(what, now);
  }

  [[nodiscard]] std::size_t size() const { return logs_.size(); }

 private:
  std::size_t most_;
  std::map<Source, FailureLog> logs_;
};

}  // namespace farshade
