/// Figures: named values gathered over frames, told as median, p95 and p99. Three groups: `error` and `wire`
/// are the same on every run, `time` is the machine's.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/network/rehearsal.h"

namespace farshade::study {

enum class Group : std::uint8_t { Error, Wire, Time };

class Figures {
 public:
  /// One more value of a figure. For Worse::Low p95 and p99 are the 5 % and 1 % quantiles.
  void add(Group group, const std::string& name, double value, Worse worse = Worse::High);

  /// `{"error": {NAME: {"median", "p95", "p99", "count"}}, "wire": .., "time": ..}`, numbers to 9 digits.
  [[nodiscard]] nlohmann::json json() const;

 private:
  struct Values {
    Worse worse;
    std::vector<double> values;
  };
  std::map<Group, std::map<std::string, Values>> groups_;
};

/// Milliseconds of client and server stages from frame `warm_up` on.
void add_times(const Played& played, std::uint32_t warm_up, Figures& figures);

/// Mask error, shares, staleness, latency, bytes, datagrams and rays from frame `warm_up` on. Frames before
/// anything had come count as start-up and in no figure.
void add_errors(const Played& played, std::uint32_t warm_up, Figures& figures);

}  // namespace farshade::study
