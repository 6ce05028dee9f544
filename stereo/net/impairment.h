/// Impairment: a seeded model of one direction of a bad network. The caller passes the time. A datagram
/// passes a bottleneck with a queue, may be lost, corrupted, duplicated or reordered, and arrives after its
/// delay. ImpairedPort (impaired_port.h) and the tests' virtual link use it.
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
#include "stereo/messages/messages.h"
#include "stereo/net/datagram.h"

namespace farshade {

/// Impairments of one direction of a path. Loss, reorder, duplicate and corrupt are independent
/// probabilities.
struct LinkModel {
  Duration delay{};   ///< least delay of every datagram
  Duration jitter{};  ///< additional delay, uniform in [0, jitter): 25±10 ms is delay 15 ms and jitter 20 ms
  double loss = 0;    ///< mean loss rate
  /// Mean number of consecutive losses. 1 means independent losses, of which 1 / (1 - loss) are consecutive
  /// on average; that is also the least possible mean. Two states, with loss in one of them: Gilbert,
  /// "Capacity of a burst-noise channel", 1960; Elliott, "Estimates of error rates for codes on burst-noise
  /// channels", 1963.
  double burst = 1;
  double reorder = 0;  ///< rate of datagrams with `reorder_by` more delay, so that later ones overtake them
  Duration reorder_by = std::chrono::milliseconds(10);
  double duplicate = 0;         ///< rate of datagrams that arrive twice, each with its own jitter
  double corrupt = 0;           ///< rate of datagrams with one flipped random bit
  double rate_bytes_per_s = 0;  ///< rate of the bottleneck, in UDP payload; 0: no bottleneck
  Duration queue = std::chrono::milliseconds(100);  ///< longest wait before the bottleneck; it drops others
  std::size_t mtu_bytes = 0;  ///< longest packet, headers of IP and UDP included; others are dropped; 0: any
  Duration silence{};         ///< length of a silence at the end of every `silence_every`
  Duration silence_every{};
  std::uint64_t seed = 1;  ///< of all random numbers of the model
  friend bool operator==(const LinkModel&, const LinkModel&) = default;
};

struct NamedNetwork {
  std::string_view name;
  LinkModel model;
};

/// Named networks for tests and for --net. Delays and rates are for one direction. If client and server both
/// use a network, a round trip passes it twice.
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

/// Parses a network: a name of kNetworks, or words such as
/// `loss=2%,burst=3,delay=25ms,jitter=5ms,reorder=2%,reorder_by=10ms,duplicate=1%,corrupt=0.5%,rate=10Mbit,`
/// `queue=100ms,mtu=1400,`
/// `silence=2s/5s,seed=7`, or a name followed by such words. Refuses other words
/// (Malformed) and bad values (OutOfRange). The error names the word and lists what is possible.
[[nodiscard]] Expected<LinkModel> parse_link_model(std::string_view text);

struct ImpairmentCounters {
  std::uint64_t lost = 0;        ///< by random loss or in a silence
  std::uint64_t overflowed = 0;  ///< dropped: the bottleneck's queue is full, or kLinkCapacity is reached
  std::uint64_t too_long = 0;    ///< dropped: longer than the path's packets
  std::uint64_t duplicated = 0, corrupted = 0, reordered = 0;
  friend bool operator==(const ImpairmentCounters&, const ImpairmentCounters&) = default;
};

/// Most datagrams in transit in one direction.
inline constexpr std::size_t kLinkCapacity = 8192;

/// A datagram between its sender and its receiver.
struct InTransit {
  Time arrival;
  std::uint64_t order = 0;  ///< serial number within one Impairment
  Peer peer;                ///< as passed to push()
  std::size_t size = 0;
  std::array<std::byte, kMaxDatagram_bytes> buffer;
  [[nodiscard]] std::span<const std::byte> bytes() const { return std::span(buffer).first(size); }
};

/// One direction of a path. It draws all random numbers for every datagram, whatever happens to it. So a
/// change of one rate does not change the other impairments.
class Impairment {
 public:
  /// The periods of silence start at `start`. Another `stream` gives other random numbers.
  Impairment(const LinkModel& model, Time start, std::uint64_t stream = 0);

  /// Uses `model`, except its seed, from now on. Datagrams in transit keep their arrival times.
  void follow(const LinkModel& model);

  /// Sends a datagram at `now`. False: kLinkCapacity datagrams are in transit already. Returns true if the
  /// model drops the datagram.
  bool push(Time now, const Peer& peer, std::span<const std::byte> bytes);

  /// The datagram that arrives first, or null. Of datagrams with the same arrival, the one that was pushed
  /// first.
  [[nodiscard]] const InTransit* front() const { return queue_.empty() ? nullptr : queue_.front(); }

  /// Removes front(). The datagram stays valid until the next push.
  void pop();

  [[nodiscard]] const ImpairmentCounters& counters() const { return counters_; }

 private:
  [[nodiscard]] double uniform();
  [[nodiscard]] bool is_silent(Time now) const;
  [[nodiscard]] bool is_too_long(const Peer& peer, std::size_t size) const;
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
  std::vector<InTransit*> free_, queue_;  ///< queue_ is a heap with the earliest arrival on top
  ImpairmentCounters counters_;
};

}  // namespace farshade
