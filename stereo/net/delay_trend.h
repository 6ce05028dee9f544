/// DelayTrend: detects a growing queue. It groups datagrams as they are sent; a group has at least
/// kGroupCount datagrams and lasts at least kGroup. The published 5 ms collect bursts, but the slices here
/// are paced. The delay of a group is the delay of its fastest datagram: a queue delays that one as well,
/// jitter does not. (The least of n uniform delays has a spread of 1/n; at 72 Hz and 25 % loss 22 datagrams
/// of a group arrive.) So a datagram that arrives after its group is closed does no harm.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "stereo/base/clock.h"

namespace farshade {

class DelayTrend {
 public:
  enum class Verdict { Normal, Overuse, Underuse };

  /// Returns the group of a datagram that is sent at `sent`. Call it in the order of sending.
  std::uint32_t group_of(Time sent);
  /// Records a datagram that arrived. `delay_ms` is arrival minus sending, on two different clocks, so only
  /// its differences have a meaning.
  void add(std::uint32_t group, Time sent, double delay_ms);

  [[nodiscard]] Verdict verdict() const { return verdict_; }

 private:
  static constexpr Duration kGroup = std::chrono::milliseconds(25);
  static constexpr std::uint32_t kGroupCount = 8;
  static constexpr Duration kLongestGroup = std::chrono::milliseconds(60);  ///< also with fewer datagrams
  static constexpr std::size_t kWindow = 20;                                ///< groups in the linear fit

  struct Group {
    std::uint32_t number = 0;
    Time sent{};  ///< of the fastest datagram, like the delay
    double delay_ms = 0;
  };

  void close(const Group& group);
  void restart();
  void detect(double trend, double step_ms);
  [[nodiscard]] double slope() const;

  std::uint32_t sending_ = 0, sending_count_ = 0;  ///< current group, and its number of datagrams
  Time sending_since_{};

  std::array<std::optional<Group>, 3> open_{};  ///< the newest group and the two before
  std::uint32_t newest_ = 0;

  std::optional<Group> first_, last_;  ///< groups closed since the restart
  double smoothed_ms_ = 0;
  std::array<double, kWindow> x_{}, y_{};
  std::size_t points_ = 0;  ///< groups closed since the restart

  double threshold_ms_ = 12.5, last_trend_ = 0, over_ms_ = 0;
  int over_ = 0;  ///< consecutive groups over the threshold
  Verdict verdict_ = Verdict::Normal;
};

}  // namespace farshade
