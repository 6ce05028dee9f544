/// RateControl: sets the send rate of a session from its client's arrival reports. It is the delay-based part
/// of Google congestion control (Carlucci et al., "Analysis and Design of the Google Congestion Control for
/// WebRTC", MMSys 2016; draft-ietf-rmcat-gcc-02; trendline filter as in libwebrtc). It reacts to growing
/// queues and ignores random loss. A loss guard reacts to policers and short queues, which drop datagrams but
/// do not delay them; without it a policer at 8 Mbit/s drops 31 % of the datagrams instead of 4 %
/// (docs/link.md). The caller passes the time. Memory is bounded.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "stereo/messages/arrival_report.h"
#include "stereo/net/delay_trend.h"
#include "stereo/net/loss_meter.h"
#include "stereo/net/received_rate.h"

namespace farshade {

struct RateLimits {
  double least = 25e3, most = 12.5e6;  ///< bytes a second
};

/// The usual least rate, unless that is more than `most`.
[[nodiscard]] constexpr RateLimits limits_up_to(double most) {
  return {.least = most < RateLimits{}.least ? most : RateLimits{}.least, .most = most};
}

class RateControl {
 public:
  /// Initial rate, bytes a second: 72 frames of 46 datagrams a second.
  static constexpr double kStart = 4e6;
  /// What a new session may send at its rate before anything is known to have arrived: about one frame. Each
  /// byte that arrives allows two more, so what is under way doubles with every round trip (slow start, RFC
  /// 9002, 7.3.1). What goes beyond it leaves with kSlow. This ends when kRamp_bytes have arrived.
  static constexpr std::int64_t kFirst_bytes = std::int64_t{64} << 10, kRamp_bytes = std::int64_t{1} << 20;
  static constexpr double kSlow = 500e3;  ///< bytes a second
  /// Number of sent datagrams that it remembers: 0.8 s at the highest rate.
  static constexpr std::size_t kRemembered = 8192;

  explicit RateControl(RateLimits limits = {});

  /// Sets the limits from now on.
  void limit(const RateLimits& limits);

  /// Records a sealed datagram that was sent. Counters are consecutive; `at` does not decrease.
  void sent(std::uint64_t counter, std::size_t bytes, Time at);
  /// The same of a datagram whose arrival says nothing about the rate: it went to an address which is not the
  /// client's proved one, or tries a size that the path may not carry.
  void sent_elsewhere(std::uint64_t counter, Time at);
  /// Records a counter that no datagram has. A report that it has arrived is a lie: whoever sends it reports
  /// arrivals without looking. From then on the rate is the least.
  void skipped(std::uint64_t counter, Time at);

  /// Processes a report of the client. Ignores arrivals that it knows already, counters that were never sent
  /// and impossible times. No report can move the rate out of its limits.
  void take(const ArrivalReport& report, Time now);

  /// The rate that the path carries, as far as the reports tell.
  [[nodiscard]] double bytes_per_second() const { return rate_; }
  /// The rate at which to send now. It is lower while reports come that know of no arrival: kUnheard after
  /// the first datagram that nothing was heard of it begins to halve every kHalving. The first arrival
  /// restores it. A new session may not send more than a little at its rate.
  [[nodiscard]] double sending_bytes_per_second() const;
  /// A client that has sent a false report on one path is not trusted on the next one either: the least rate
  /// from now on.
  void distrust();
  /// A report has named a skipped counter as arrived, or distrust() was called.
  [[nodiscard]] bool got_false_report() const { return got_false_report_; }
  /// Share of lost datagrams in the last window, without outages.
  [[nodiscard]] double loss() const { return losses_.loss(); }
  /// The path's base loss, which does not depend on the rate.
  [[nodiscard]] double base_loss() const { return losses_.base(); }

 private:
  enum class Outcome : std::uint8_t { Unreported, Absent, Arrived, Elsewhere, Skipped };
  struct Record {
    Time at{};
    std::uint32_t group = 0;
    std::uint16_t bytes = 0;
    Outcome outcome = Outcome::Unreported;
  };
  /// A lower rate because of loss, until a window sent at this rate shows whether it helped.
  struct Trial {
    double rate_before, loss_before;
  };

  [[nodiscard]] Record* find(std::uint64_t counter);
  bool learn(const ArrivalReport& report, Time now);
  void record(std::uint64_t counter, const Record& sent);
  void judge_losses();
  void adapt_to_delay(Time now);
  void adapt_to_loss(Time now);
  void raise(double seconds);
  void lower_to(double bytes_per_second, Time now);
  /// The rate that the path carries: the received rate, corrected for the base loss.
  [[nodiscard]] std::optional<double> carried() const;

  RateLimits limits_;
  std::vector<Record> records_;        ///< kRemembered, from the first datagram on
  std::uint64_t next_ = 0;             ///< counter of the next datagram
  std::uint64_t oldest_ = 0;           ///< oldest remembered counter
  std::uint64_t judged_ = 0;           ///< losses before this counter are counted
  Time newest_arrived_{};              ///< send time of that datagram
  std::optional<Time> unheard_since_;  ///< when the first datagram after the last news was sent
  Duration unheard_{};                 ///< from then to the newest report

  DelayTrend trend_;
  ReceivedRate received_;
  LossMeter losses_;

  double rate_ = kStart;
  std::int64_t allowed_bytes_ = kFirst_bytes;   ///< of a new session
  std::int64_t ramp_left_bytes_ = kRamp_bytes;  ///< that must arrive until the session is not new any more
  bool got_false_report_ = false;
  Duration round_trip_ = std::chrono::milliseconds(100);  ///< from sending to the report
  std::optional<double> capacity_;                        ///< rate that the path carried at the last decrease
  std::optional<Time> adapted_, lowered_;
  std::optional<Trial> trial_;
  int excessive_ = 0;  ///< consecutive windows; a single one may be a burst
};

}  // namespace farshade
