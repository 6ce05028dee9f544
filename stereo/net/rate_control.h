/// RateControl: sets the send rate of a session from its client's arrival reports. It is the delay-based part
/// of Google congestion control (Carlucci et al., "Analysis and Design of the Google Congestion Control for
/// WebRTC", MMSys 2016; draft-ietf-rmcat-gcc-02; trendline filter as in libwebrtc). It reacts to growing
/// queues and ignores random loss. A loss guard reacts to policers and short queues, which drop datagrams but
/// do not delay them; without it a policer at 8 Mbit/s drops 31 % of the datagrams instead of 4 %
/// (docs/link.md). The caller passes the time. Memory is bounded.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "stereo/messages/arrival_report.h"

namespace farshade {

/// Detects a growing queue. It groups datagrams as they are sent; a group has at least kGroupCount datagrams
/// and lasts at least kGroup. The published 5 ms collect bursts, but the slices here are paced. The delay of
/// a group is the delay of its fastest datagram: a queue delays that one as well, jitter does not. (The least
/// of n uniform delays has a spread of 1/n; at 72 Hz and 25 % loss 22 datagrams of a group arrive.) So a
/// datagram that arrives after its group is closed does no harm.
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

/// The received rate over the last half second of arrivals, on the client's clock.
class ReceivedRate {
 public:
  void add(Time arrived, std::size_t bytes);
  /// Returns nothing before 100 ms of arrivals are known.
  [[nodiscard]] std::optional<double> bytes_per_second() const;

 private:
  static constexpr Duration kBucket = std::chrono::milliseconds(25);
  static constexpr std::int64_t kBuckets = 21;  ///< the newest is incomplete and not counted

  std::array<std::uint64_t, kBuckets> bytes_{};
  std::int64_t first_ = 0, newest_ = 0;  ///< bucket numbers
  bool any_ = false;
};

/// Measures the share of lost datagrams over windows of sending time, and the path's base loss: the least
/// share of about the last 10 s. A time of 250 ms or more without any arrival is an outage and not counted as
/// loss.
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
