/// The addresses at which other machines can reach this one.
#pragma once

#include <vector>

#include "stereo/net/datagram.h"

namespace farshade {

/// With `port`, IPv4 first, otherwise in the system's order. Leaves out loopback and link-local addresses and
/// interfaces that are down. Empty if there are none.
[[nodiscard]] std::vector<Peer> local_addresses(std::uint16_t port);

}  // namespace farshade
