/// Real UDP behind the datagram seam, IPv4 and IPv6. udp.cpp is the one file that names asio.
/// Sockets stay unconnected: no ICMP error can end a session, and a client outlives a change of its own
/// address.
#pragma once

#include <memory>
#include <string_view>

#include "stereo/base/expected.h"
#include "stereo/net/datagram.h"

namespace farshade {

/// What is asked of the kernel for either direction; it may grant less (net.core.rmem_max).
inline constexpr int kSocketBuffer_bytes = 4 << 20;

/// A port that listens on `address` (`127.0.0.1:7447`, `[::]:0`, `name:port`); port 0 lets the system choose,
/// and
/// `[::]` takes IPv4 too. Refuses bad addresses (Malformed), unknown names and foreign addresses (Missing), a
/// port in use (Unavailable).
[[nodiscard]] Expected<std::unique_ptr<DatagramPort>> listen_udp(std::string_view address);

struct UdpClient {
  std::unique_ptr<DatagramPort> port;  ///< hears nobody but `server`
  Peer server;
};

/// A port of the system's choice that talks to `address`. Nothing is sent: whether somebody listens there
/// shows when answers come.
[[nodiscard]] Expected<UdpClient> connect_udp(std::string_view address);

}  // namespace farshade
