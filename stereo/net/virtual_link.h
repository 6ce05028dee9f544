/// An in-process link in virtual time behind the datagram seam: a client's and a server's port, and between
/// them what LinkModel says of each direction. Who waits moves the clock; nothing else passes time, so a run
/// is the same datagrams at the same instants every time, and staleness can be set.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "stereo/net/datagram.h"

namespace farshade {

/// What one direction of a path does to a datagram.
struct LinkModel {
  Duration delay{};   ///< every datagram's least time on the way
  Duration jitter{};  ///< more, uniform in [0, jitter): datagrams may overtake each other
  double loss = 0;    ///< probability of not arriving
};

/// Both directions and the seed of everything random in them.
struct LinkModels {
  LinkModel to_server, to_client;
  std::uint64_t seed = 1;
};

/// Most datagrams on the way in one direction; more are dropped and counted as unsent.
inline constexpr std::size_t kLinkCapacity = 8192;

/// Not for use by several threads. Datagrams that arrive at the same instant keep the order in which they
/// were sent.
class VirtualLink {
 public:
  /// `clock` outlives the link.
  VirtualLink(ManualClock& clock, const LinkModels& models);
  ~VirtualLink();

  [[nodiscard]] DatagramPort& client();
  [[nodiscard]] DatagramPort& server();

  /// `others` stands for the program at the far end: it runs whenever a port that waits sees a datagram
  /// arrive at the other port, so that an answer can come within the wait. It must not wait itself.
  void while_waiting(std::function<void()> others);

  /// When the next datagram reaches either port, if any is on the way or lies unread.
  [[nodiscard]] std::optional<Time> next_arrival() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace farshade
