/// RateControl: how fast a session's datagrams may leave, from what its client says has arrived. The
/// delay-based half of Google congestion control (Carlucci et al., "Analysis and Design of the Google
/// Congestion Control for WebRTC", MMSys 2016; draft-ietf-rmcat-gcc-02; trendline filter as in libwebrtc). It
/// feels queues grow and takes random loss for what it is. One guard of our own sees policers and short
/// queues, which lose but do not delay. Values only: time is passed in, memory is fixed.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "stereo/wire/arrival_report.h"

namespace farshade {

/// Is a queue growing? Datagrams are grouped as they are sent, at least kGroup and kGroupCount each. The
/// published 5 ms groups bursts; our slices are paced, a burst is no more than one of them. A group's delay
/// is that of its fastest datagram: a queue holds up that one too, jitter does not (the least of n uniform
/// delays varies as 1/n; 22 come of a group at 72 Hz and 25 % loss). A datagram later than its group is not
/// missed: it was not the fastest.
class DelayTrend {
 public:
  enum class Verdict { Normal, Overuse, Underuse };

  /// The group of a datagram that leaves now. Call in order.
  std::uint32_t group_of(Time sent);
  /// A datagram that arrived. `delay_ms` is arrival less sending, on two clocks: only differences count.
  void add(std::uint32_t group, Time sent, double delay_ms);

  [[nodiscard]] Verdict verdict() const { return verdict_; }

 private:
  static constexpr Duration kGroup = std::chrono::milliseconds(25);
  static constexpr std::uint32_t kGroupCount = 8;
  static constexpr Duration kLongestGroup = std::chrono::milliseconds(60);  ///< whatever the count
  static constexpr std::size_t kWindow = 20;                                ///< groups in the line's fit

  struct Group {
    std::uint32_t number = 0;
    Time sent{};  ///< of the fastest, as the delay
    double delay_ms = 0;
  };

  void close(const Group& group);
  void restart();
  void detect(double trend, double step_ms);
  [[nodiscard]] double slope() const;

  std::uint32_t sending_ = 0, sending_count_ = 0;  ///< the group that is being sent, and what it has
  Time sending_since_{};

  std::array<std::optional<Group>, 3> open_{};  ///< the newest and the two before
  std::uint32_t newest_ = 0;

  std::optional<Group> first_, last_;  ///< closed since the restart
  double smoothed_ms_ = 0;
  std::array<double, kWindow> x_{}, y_{};
  std::size_t points_ = 0;  ///< closed since the restart

  double threshold_ms_ = 12.5, last_trend_ = 0, over_ms_ = 0;
  int over_ = 0;  ///< groups over the threshold, in a row
  Verdict verdict_ = Verdict::Normal;
};

/// Bytes a second over the last half second of arrivals, on the client's clock.
class ReceivedRate {
 public:
  void add(Time arrived, std::size_t bytes);
  /// None until 100 ms are known.
  [[nodiscard]] std::optional<double> bytes_per_second() const;

 private:
  static constexpr Duration kBucket = std::chrono::milliseconds(25);
  static constexpr std::int64_t kBuckets = 21;  ///< the newest is not full yet and does not count

  std::array<std::uint64_t, kBuckets> bytes_{};
  std::int64_t first_ = 0, newest_ = 0;  ///< bucket numbers
  bool any_ = false;
};

/// Share of datagrams that did not come, over windows of sending time, and the path's own: the least of about
/// 10 s. A stretch of 250 ms and more of which nothing came is an outage: it is not counted.
class LossMeter {
 public:
  /// Datagrams in the order of their sending.
  void arrived(Time sent);
  void lost(Time sent);
  void untold(Time sent);  ///< no report spoke of it: part of an outage, if there is one, never a loss

  /// The window that has filled since the last call, if one has.
  [[nodiscard]] std::optional<double> next_window();
  /// Starts the window again, with what is sent from `from` on.
  void restart(Time from);
  /// More than the path's own loss accounts for: base + 10 % + two standard deviations of a window's count.
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
  std::optional<Time> run_start_;  ///< of losses in a row
  std::uint32_t run_ = 0;
  double loss_ = 0, base_now_ = 0, base_before_ = 0;  ///< least of these 5 s, and of the 5 s before
  std::optional<Time> base_since_;
};

struct RateLimits {
  double least = 25e3, most = 12.5e6;  ///< bytes a second
};

class RateControl {
 public:
  /// Before anything is known, bytes a second: 72 frames a second of 46 datagrams.
  static constexpr double kStart = 4e6;
  /// Sent datagrams that are remembered: 0.8 s at the highest rate.
  static constexpr std::size_t kRemembered = 8192;

  explicit RateControl(RateLimits limits = {});

  /// A sealed datagram left. Counters go up by one, `at` does not go back.
  void sent(std::uint64_t counter, std::size_t bytes, Time at);

  /// What the client says. Known things, things never sent and impossible times are passed over; nothing that
  /// a report says takes the rate out of its limits.
  void heard(const ArrivalReport& report, Time now);

  [[nodiscard]] double bytes_per_second() const { return rate_; }
  /// Share of datagrams lost, of the last window; outages are not counted.
  [[nodiscard]] double loss() const { return losses_.loss(); }
  /// Of it, the path's own, whatever the rate.
  [[nodiscard]] double base_loss() const { return losses_.base(); }
  /// A queue is growing now.
  [[nodiscard]] bool is_congested() const { return trend_.verdict() == DelayTrend::Verdict::Overuse; }

 private:
  enum class Fate : std::uint8_t { Untold, Absent, Arrived };
  struct Record {
    Time at{};
    std::uint32_t group = 0;
    std::uint16_t bytes = 0;
    Fate fate = Fate::Untold;
  };
  /// A rate lowered for its loss, until a window sent at the lower rate says whether that helped.
  struct Trial {
    double rate_before, loss_before;
  };

  [[nodiscard]] Record* find(std::uint64_t counter);
  bool learn(const ArrivalReport& report, Time now);
  void judge_losses();
  void adapt_to_delay(Time now);
  void adapt_to_loss(Time now);
  void raise(double seconds);
  void lower_to(double bytes_per_second, Time now);
  /// What the path brings, without its own loss.
  [[nodiscard]] std::optional<double> carried() const;

  RateLimits limits_;
  std::array<Record, kRemembered> records_{};
  std::uint64_t next_ = 0;    ///< counter to be sent next
  std::uint64_t oldest_ = 0;  ///< counter remembered
  std::uint64_t judged_ = 0;  ///< before this one, what is lost has been counted
  Time newest_arrived_{};     ///< its sending

  DelayTrend trend_;
  ReceivedRate received_;
  LossMeter losses_;

  double rate_ = kStart;
  Duration round_trip_ = std::chrono::milliseconds(100);  ///< from sending to hearing of it
  std::optional<double> capacity_;                        ///< what the path carried when it was last too much
  std::optional<Time> adapted_, lowered_;
  std::optional<Trial> trial_;
  int excessive_ = 0;  ///< windows in a row; one alone may be a burst
};

}  // namespace farshade
