/// Impairment: one seeded model of a bad network, in time that it is told. A datagram passes a bottleneck
/// with a queue, may be lost, corrupted, doubled or held back, and arrives after its delay. Both directions
/// of the virtual link (virtual_link.h) and live ports (impaired_port.h) are this.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <random>
#include <span>
#include <string_view>
#include <vector>

#include "stereo/base/clock.h"
#include "stereo/base/expected.h"
#include "stereo/net/datagram.h"
#include "stereo/wire/messages.h"

namespace farshade {

/// What one direction of a path does to its datagrams. Rates are probabilities, each for itself.
struct LinkModel {
  Duration delay{};   ///< every datagram's least time on the way
  Duration jitter{};  ///< more, uniform in [0, jitter): 25±10 ms is a delay of 15 ms and a jitter of 20 ms
  double loss = 0;    ///< mean rate of not arriving
  /// Mean number of datagrams lost in a row, never less than independent losses have, 1 / (1 - loss): 1 means
  /// independent. Two states, in one of which all is lost: Gilbert, "Capacity of a burst-noise channel",
  /// 1960; Elliott, "Estimates of error rates for codes on burst-noise channels", 1963.
  double burst = 1;
  double reorder = 0;  ///< held back by `reorder_by` more than its delay, so that others overtake it
  Duration reorder_by = std::chrono::milliseconds(10);
  double duplicate = 0;                             ///< arrives twice, the second with a jitter of its own
  double corrupt = 0;                               ///< one random bit of it is flipped
  double rate_bytes_per_s = 0;                      ///< the bottleneck, in datagram payload; 0: none
  Duration queue = std::chrono::milliseconds(100);  ///< longest wait before the bottleneck: more is dropped
  Duration silence{};                               ///< the last so much of every `silence_every` is lost
  Duration silence_every{};
  std::uint64_t seed = 1;  ///< of everything random here
  friend bool operator==(const LinkModel&, const LinkModel&) = default;
};

struct NamedNetwork {
  std::string_view name;
  LinkModel model;
};

/// The networks that everything is tested over. Delays are one way, rates are of one direction: a client and
/// a server that both meet a network meet it twice in a round trip.
inline constexpr std::array<NamedNetwork, 12> kNetworks = [] {
  using std::chrono::milliseconds, std::chrono::seconds;
  constexpr LinkModel poor{
      .delay = milliseconds(40), .jitter = milliseconds(20), .loss = 0.05, .duplicate = 0.01};
  LinkModel poor3 = poor, poor8 = poor;
  poor3.burst = 3;
  poor8.burst = 8;
  return std::array<NamedNetwork, 12>{{
      {"none", {}},
      {"wifi", {.delay = milliseconds(4), .jitter = milliseconds(2), .loss = 0.02, .reorder = 0.02}},
      {"poor", poor},
      {"poor-burst3", poor3},
      {"poor-burst8", poor8},
      {"bad", {.delay = milliseconds(100), .loss = 0.2, .reorder = 0.04}},
      {"hostile", {.delay = milliseconds(50), .jitter = milliseconds(100), .loss = 0.25, .duplicate = 0.25}},
      {"reorder", {.delay = milliseconds(40), .reorder = 0.3, .reorder_by = milliseconds(40)}},
      {"corrupt2", {.corrupt = 0.02}},
      {"corrupt30", {.corrupt = 0.3}},
      {"silent", {.silence = seconds(2), .silence_every = seconds(5)}},
      {"dead", {.loss = 1}},
  }};
}();

/// A network as people write it: a name of kNetworks, or words such as
/// `loss=2%,burst=3,delay=25ms,jitter=5ms,reorder=2%,reorder_by=10ms,duplicate=1%,corrupt=0.5%,rate=10Mbit,`
/// `queue=100ms,silence=2s/5s,seed=7`, or a name followed by such words. Refuses anything else (Malformed)
/// and values that mean nothing (OutOfRange), names the word and says what there is.
[[nodiscard]] Expected<LinkModel> parse_link_model(std::string_view text);

struct ImpairmentCounters {
  std::uint64_t lost = 0;        ///< by chance or in silence
  std::uint64_t overflowed = 0;  ///< found the queue before the bottleneck, or kLinkCapacity, full
  std::uint64_t duplicated = 0, corrupted = 0, reordered = 0;
  friend bool operator==(const ImpairmentCounters&, const ImpairmentCounters&) = default;
};

/// Most datagrams on the way in one direction.
inline constexpr std::size_t kLinkCapacity = 8192;

/// A datagram between its sender and its receiver.
struct InTransit {
  Time arrival;
  std::uint64_t order = 0;  ///< counts up within one Impairment: tells datagrams apart
  Peer peer;                ///< as it was given
  std::size_t size = 0;
  std::array<std::byte, kMaxDatagram_bytes> buffer;
  [[nodiscard]] std::span<const std::byte> bytes() const { return std::span(buffer).first(size); }
};

/// One direction in time. All random numbers are drawn for every datagram, whatever happens to it: another
/// rate of one mishap leaves all others as they were.
class Impairment {
 public:
  /// Silence is counted from `start`. `stream` makes another run of the same model.
  Impairment(const LinkModel& model, Time start, std::uint64_t stream = 0);

  /// From now on datagrams meet `model`, its seed aside; those on the way keep their times.
  void follow(const LinkModel& model);

  /// Takes a datagram that sets out at `now`. False: kLinkCapacity are on the way already. What the model
  /// drops was sent all the same.
  bool push(Time now, const Peer& peer, std::span<const std::byte> bytes);

  /// The datagram that arrives first, of the same instant the one pushed first; null if there is none.
  [[nodiscard]] const InTransit* front() const { return queue_.empty() ? nullptr : queue_.front(); }

  /// Takes front() away; its memory stays as it is until the next push.
  void pop();

  /// Drops all that is on the way and says how many those were.
  std::size_t clear();

  [[nodiscard]] const ImpairmentCounters& counters() const { return counters_; }

 private:
  [[nodiscard]] double uniform();
  [[nodiscard]] bool is_silent(Time now) const;
  [[nodiscard]] bool loses(double draw);
  [[nodiscard]] std::optional<Time> past_bottleneck(Time now, std::size_t size);
  [[nodiscard]] Time arrival(Time left, double jitter_draw) const;
  InTransit* put(Time arrival, const Peer& peer, std::span<const std::byte> bytes);

  LinkModel model_;
  Time start_;
  std::mt19937_64 random_;
  bool in_burst_ = false;
  Time bottleneck_free_;
  std::uint64_t next_order_ = 0;
  std::vector<std::unique_ptr<InTransit>> owned_;
  std::vector<InTransit*> free_, queue_;  ///< queue_ is a heap, the earliest on top
  ImpairmentCounters counters_;
};

}  // namespace farshade
