/// Arrivals: the client's side of the rate control. It notes which sealed datagrams came and when, and says
/// so in an ArrivalReport with every request. What came is said in several reports, so that a lost one costs
/// nothing. Fixed memory: the newest ArrivalReport::kMost counters.
#pragma once

#include <algorithm>
#include <array>
#include <limits>

#include "stereo/wire/arrival_report.h"

namespace farshade {

class Arrivals {
 public:
  /// Reports that tell of each datagram: a quarter of the reports lost leaves 0.4 % of the datagrams untold.
  static constexpr std::size_t kTold = 4;

  /// A datagram that opened, in any order, never the same twice. `arrived` is on the client's clock.
  void add(std::uint64_t counter, Time arrived);

  /// For the next request, once a request. Goes back to the oldest datagram that was news, as come or as
  /// skipped by a newer one, in this report or the kTold - 1 before it, as far as it is among the newest
  /// kMost counters and no more than 65,534 ticks (4.2 s) before the latest arrival. Empty (`count` 0) when
  /// nothing came in that time.
  [[nodiscard]] ArrivalReport report();

  [[nodiscard]] std::uint64_t received() const { return received_; }
  /// Not here yet, of all from the first that came to the newest.
  [[nodiscard]] std::uint64_t missing() const;

 private:
  static constexpr std::size_t kKept = ArrivalReport::kMost;
  static constexpr std::uint64_t kNothing = std::numeric_limits<std::uint64_t>::max();

  struct Slot {
    bool here = false;
    Time arrived{};
  };

  [[nodiscard]] const Slot& slot(std::uint64_t counter) const { return slots_[counter % kKept]; }
  [[nodiscard]] std::uint64_t oldest_to_tell() const;

  std::array<Slot, kKept> slots_{};  ///< of the counters (newest_ - kKept, newest_]
  std::uint64_t newest_ = 0;
  std::uint64_t oldest_ = kNothing;  ///< least counter that ever came
  std::uint64_t received_ = 0;
  std::array<std::uint64_t, kTold> fresh_from_ =
      filled();  ///< oldest counter that was news in a report; [0]: the next one

  static constexpr std::array<std::uint64_t, kTold> filled() {
    std::array<std::uint64_t, kTold> all{};
    all.fill(kNothing);
    return all;
  }
};

}  // namespace farshade
