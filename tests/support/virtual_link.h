/// VirtualLink: a network inside one process, in virtual time. It has the ports of a server and of its
/// clients, and a LinkModel for each direction between them. Only a port that waits advances the clock. So
/// every run has the same datagrams at the same times.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "stereo/net/datagram.h"
#include "stereo/net/impairment.h"
#include "tests/support/manual_clock.h"

namespace farshade {

/// The models of both directions of each client's path. `seed` is combined with the models' own seeds.
struct LinkModels {
  LinkModel to_server, to_client;
  std::uint64_t seed = 1;
};

/// For one thread only. Datagrams from one sender that arrive at the same time keep their order; datagrams
/// from several clients arrive in the order of the clients. A send fails if kLinkCapacity datagrams are in
/// transit already.
class VirtualLink {
 public:
  /// `clock` must outlive the link.
  VirtualLink(ManualClock& clock, const LinkModels& models, std::size_t clients = 1);
  VirtualLink(const VirtualLink&) = delete;
  VirtualLink& operator=(const VirtualLink&) = delete;
  ~VirtualLink();

  [[nodiscard]] DatagramPort& client(std::size_t i = 0);
  [[nodiscard]] DatagramPort& server();

  /// Gives client `i` a new address. Datagrams that it sent before still arrive from the old address.
  /// Datagrams to the old address are lost without an error.
  void move_client(std::size_t i);
  /// Number of datagrams that were lost at old addresses.
  [[nodiscard]] std::uint64_t lost_to_old_addresses() const;

  /// `others` runs the programs at the other ports. A waiting port calls it whenever a datagram arrives at
  /// another port, so that an answer can arrive within the wait. It must not wait itself. `due` returns the
  /// time at which these programs have work without a datagram; `others` runs then as well and must do that
  /// work.
  void while_waiting(std::function<void()> others, std::function<std::optional<Time>()> due = {});

  /// The arrival time of the next datagram at any port, if one is in transit or unread.
  [[nodiscard]] std::optional<Time> next_arrival() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace farshade
