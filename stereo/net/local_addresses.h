/// The addresses at which other machines can reach this one.
#pragma once

#include <vector>

#include "stereo/net/datagram.h"

namespace farshade {

/// With `port`, IPv4 first, otherwise in the system's order. Leaves out loopback and link-local addresses and
/// interfaces that are down. Empty if there are none.
[[nodiscard]] std::vector<Peer> local_addresses(std::uint16_t port);

/// The index of the interface that has the address of `peer`; 0 if none has it.
[[nodiscard]] std::uint32_t interface_of(const Peer& peer);

}  // namespace farshade
