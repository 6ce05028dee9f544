/// LossMeter: measures the share of lost datagrams over windows of sending time, and the path's base loss:
/// the least share of about the last 10 s. A time of 250 ms or more without any arrival is an outage and not
/// counted as loss.
#pragma once

#include <cstdint>
#include <optional>

#include "stereo/base/clock.h"

namespace farshade {

class LossMeter {
 public:
  /// The outcome of each datagram, in the order of sending.
  void arrived(Time sent);
  void lost(Time sent);
  void unreported(Time sent);  ///< in no report: may be part of an outage, but is not a loss

  /// Returns the share of lost datagrams of a window that has ended since the last call.
  [[nodiscard]] std::optional<double> next_window();
  /// Starts a new window with the datagrams that are sent from `from` on.
  void restart(Time from);
  /// Whether `loss` is above the base loss by more than 10 % and two standard deviations of a window.
  [[nodiscard]] bool is_excessive(double loss) const;
  void set_base(double loss) { base_now_ = base_before_ = loss; }

  [[nodiscard]] double loss() const { return loss_; }
  [[nodiscard]] double base() const { return base_now_ < base_before_ ? base_now_ : base_before_; }

 private:
  static constexpr std::uint32_t kLeastCount = 128;

  void settle(Time sent);

  Time from_{}, counted_to_{};
  std::optional<Time> window_start_;
  std::uint32_t count_ = 0, lost_ = 0;
  std::optional<Time> run_start_;  ///< first of the current consecutive losses
  std::uint32_t run_ = 0;
  double loss_ = 0, base_now_ = 0, base_before_ = 0;  ///< bases: least loss of the current and the last 5 s
  std::optional<Time> base_since_;
};

}  // namespace farshade
