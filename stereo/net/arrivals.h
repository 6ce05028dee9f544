/// Arrivals: the client's side of the rate control. It records which sealed datagrams arrived and when, and
/// makes the ArrivalReport of every request. Each arrival is in several reports, so that a lost report does
/// no harm. Its memory is fixed: it remembers the newest ArrivalReport::kMost counters.
#pragma once

#include <algorithm>
#include <array>
#include <limits>

#include "stereo/messages/arrival_report.h"

namespace farshade {

class Arrivals {
 public:
  /// Number of reports that contain an arrival. If a quarter of the reports is lost, the server does not
  /// learn of 0.4 % of the arrivals.
  static constexpr std::size_t kReports = 4;

  /// Records a datagram that opened, so that its counter is at most ReplayWindow::kMostCounter. Datagrams may
  /// come in any order, each of them once. `arrived` is on the
  /// client's clock.
  void add(std::uint64_t counter, Time arrived);

  /// The report for the next request; call it once for each request. It begins with the oldest datagram that
  /// has arrived, or was skipped by a newer one, since the last kReports - 1 reports. It leaves out datagrams
  /// that are not among the newest kMost counters, and arrivals more than 65,534 ticks (4.2 s) before the
  /// latest one. It is empty (`count` 0) if nothing has arrived in that time.
  [[nodiscard]] ArrivalReport report();

  [[nodiscard]] std::uint64_t received() const { return received_; }
  /// Datagrams that have not arrived, of all between the first and the newest that have.
  [[nodiscard]] std::uint64_t missing() const;

 private:
  static constexpr std::size_t kKept = ArrivalReport::kMost;
  static constexpr std::uint64_t kNothing = std::numeric_limits<std::uint64_t>::max();

  struct Slot {
    bool has_arrived = false;
    Time arrived{};
  };

  [[nodiscard]] const Slot& slot(std::uint64_t counter) const { return slots_[counter % kKept]; }
  [[nodiscard]] std::uint64_t oldest_to_report() const;

  std::array<Slot, kKept> slots_{};  ///< for the counters (newest_ - kKept, newest_]
  std::uint64_t newest_ = 0;
  std::uint64_t oldest_ = kNothing;  ///< least counter that ever arrived
  std::uint64_t received_ = 0;
  std::array<std::uint64_t, kReports> fresh_from_ =
      filled();  ///< oldest new counter of each report; [0] is the next report

  static constexpr std::array<std::uint64_t, kReports> filled() {
    std::array<std::uint64_t, kReports> all{};
    all.fill(kNothing);
    return all;
  }
};

}  // namespace farshade
