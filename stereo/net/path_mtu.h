/// PathMtu: finds the largest datagram that the path to a client carries, by probing: RFC 8899 (Datagram
/// Packetization Layer Path MTU Discovery). It learns of arrivals from the client's arrival reports, and
/// believes no ICMP message. A value; the caller passes the time. Memory is bounded.
///
/// Of the RFC's states, Error is missing: a path that does not carry kBaseDatagram_bytes carries no session.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "stereo/messages/messages.h"

namespace farshade {

class PathMtu {
 public:
  /// The sizes that are tried, in bytes of UDP payload. 1,372: a tunnel of 1,420 bytes over IPv6 (WireGuard);
  /// 1,444: PPPoE (1,492) and Ethernet over IPv6; the last one: Ethernet over IPv4.
  static constexpr std::array<std::size_t, 4> kSizes{kBaseDatagram_bytes, 1372, 1444, kMaxDatagram_bytes};
  /// So many probes of a size are lost before the search ends (MAX_PROBES).
  static constexpr int kMostProbes = 3;
  /// A probe that no report knows of by then is lost (PROBE_TIMER, whose least value this is).
  static constexpr Duration kProbeTimer = std::chrono::seconds(1);
  /// The time after which a larger size is tried again (PMTU_RAISE_TIMER).
  static constexpr Duration kRaiseTimer = std::chrono::minutes(10);
  /// The same after the first black hole; each further one doubles it, up to kRaiseTimer.
  static constexpr Duration kAfterBlackHole = std::chrono::seconds(10);
  /// A black hole: of so many datagrams above a size none has arrived, and none longer than them, although so
  /// many shorter ones that were sent after them have. With 25 % random loss, 32 such losses have a
  /// probability of 5e-20.
  static constexpr int kLostInBlackHole = 32, kArrivedBeyond = 4;
  /// A datagram is lost if one that was sent later arrived so long ago, or up to twice as long.
  static constexpr Duration kLate = std::chrono::milliseconds(250);

  enum class State : std::uint8_t {
    Base,       ///< nothing has arrived yet, or the path has turned out to be a black hole
    Searching,  ///< probes are sent
    Complete,   ///< no larger size is tried for now
  };

  /// The largest datagram to send: one of kSizes.
  [[nodiscard]] std::size_t bytes() const { return kSizes[carried_]; }
  [[nodiscard]] State state() const { return state_; }

  /// Black holes so far.
  [[nodiscard]] std::uint64_t black_holes() const { return black_holes_; }

  /// The size of a probe that is to be sent now; nothing if none is. Call probed() after it was sent.
  [[nodiscard]] std::optional<std::size_t> next_probe(Time now);
  void probed(std::uint64_t counter, Time now);

  /// Records a sealed datagram that was sent to the client, other than a probe. Counters increase; those in
  /// between belong to datagrams whose fate does not matter.
  void sent(std::uint64_t counter, std::size_t bytes);

  /// Processes a report of the client. Ignores counters that were never sent.
  void take(const ArrivalReport& report, Time now);

 private:
  /// Number of sent datagrams that it remembers, as RateControl does.
  static constexpr std::size_t kRemembered = 8192;
  /// Number of datagrams among which a black hole is looked for.
  static constexpr std::size_t kExamined = 512;
  /// What was sent with a counter: kOther, or a datagram's size, and whether it has arrived.
  static constexpr std::uint16_t kOther = 0, kArrived = 0x8000;

  void remember(std::uint64_t counter, std::uint16_t what);
  [[nodiscard]] bool learn(const ArrivalReport& report);
  void search();
  [[nodiscard]] bool is_black_hole() const;

  State state_ = State::Base;
  std::size_t carried_ = 0;  ///< index in kSizes
  std::uint64_t black_holes_ = 0;
  std::optional<Time> search_at_;                    ///< when the search begins (again)
  Duration again_ = kAfterBlackHole;                 ///< after the next black hole
  std::array<std::uint64_t, kMostProbes> probes_{};  ///< counters of the probes of the size that is tried
  int probes_sent_ = 0;
  Time probed_at_{};                           ///< the last of them
  std::vector<std::uint16_t> sent_;            ///< kRemembered, from the first datagram on
  std::uint64_t next_ = 0;                     ///< counter of the next datagram
  std::uint64_t arrived_to_ = 0;               ///< counter after the newest datagram that has arrived
  std::uint64_t marked_ = 0, settled_to_ = 0;  ///< arrived_to_ at marked_at_, and kLate or more before that
  Time marked_at_{};
  std::uint64_t carried_from_ = 0;  ///< counter of the first datagram after carried_ has changed
};

}  // namespace farshade
