/// An in-process link in virtual time behind the datagram seam: the ports of a server and of its clients, and
/// between them what LinkModel says of each direction. Who waits moves the clock; nothing else passes time,
/// so a run is the same datagrams at the same instants every time, and staleness can be set.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "stereo/net/datagram.h"
#include "stereo/net/impairment.h"

namespace farshade {

/// Both directions of each client's path and the seed of everything random in them, mixed with the models'
/// own.
struct LinkModels {
  LinkModel to_server, to_client;
  std::uint64_t seed = 1;
};

/// Not for use by several threads. Datagrams of one sender that arrive at the same instant keep the order in
/// which they were sent; those of several clients come in the order of the clients. A send is refused when
/// kLinkCapacity datagrams are on its way already.
class VirtualLink {
 public:
  /// `clock` outlives the link.
  VirtualLink(ManualClock& clock, const LinkModels& models, std::size_t clients = 1);
  ~VirtualLink();

  [[nodiscard]] DatagramPort& client(std::size_t i = 0);
  [[nodiscard]] DatagramPort& server();

  /// Gives client `i` a new address. What it sent before still arrives from the old one; what is or will be
  /// sent to the old one is lost without anyone being told.
  void move_client(std::size_t i);
  /// How many datagrams that were.
  [[nodiscard]] std::uint64_t lost_to_old_addresses() const;

  /// `others` stands for the programs at the far end: it runs whenever a port that waits sees a datagram
  /// arrive at another port, so that an answer can come within the wait. It must not wait itself. `due` says
  /// when they have something to do though nothing reaches them; they run then, too, and must then do it.
  void while_waiting(std::function<void()> others, std::function<std::optional<Time>()> due = {});

  /// When the next datagram reaches any port, if one is on the way or lies unread.
  [[nodiscard]] std::optional<Time> next_arrival() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace farshade
