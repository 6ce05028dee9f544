/// Figures: named values of all frames, summarised as median, p95 and p99. The groups `error` and `wire` are
/// the same in every run; `time` depends on the machine.
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
  /// Adds a value to a figure. For Worse::Low, p95 and p99 are the 5 % and 1 % quantiles.
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

/// The network whose round trip a mode waits for: an ideal one if it requests nothing.
[[nodiscard]] LinkModel awaited(Mode mode, const LinkModel& each_way);

/// Round trip of the network in display frames, rounded up: the first answer cannot be shown earlier.
[[nodiscard]] std::uint32_t round_trip_frames(const LinkModel& each_way, double refresh_hz);

/// Number of frames between the first frame with an answer and the first frame that is timed: one more round
/// trip, until answers arrive that were requested with a known latency, and the frames of kMaxMasks requests,
/// until the client shades with as many masks as it can use.
[[nodiscard]] std::uint32_t warm_up_frames(const LinkModel& each_way, double refresh_hz);

/// Index of the first frame to time: `warm_up` frames after the first frame that was shown with an answer.
/// The number of frames, if no answer arrived in time.
[[nodiscard]] std::uint32_t first_timed_frame(const Played& played, std::uint32_t warm_up);

/// Milliseconds of client and server stages, of all frames from index `first` on. Leaves out the client's
/// times of frames in which it compiled a pipeline.
void add_times(const Played& played, std::uint32_t first, Figures& figures);

/// Mask error, shares, staleness, latency, bytes, datagrams and rays from frame `warm_up` on. Frames before
/// the first answer are start-up frames and count in no figure.
void add_errors(const Played& played, std::uint32_t warm_up, Figures& figures);

}  // namespace farshade::study
