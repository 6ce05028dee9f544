/// DatagramPort over UDP, IPv4 and IPv6.
/// The sockets are unconnected. So an ICMP error cannot end a session, and a session survives a change of the
/// client's own address.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stereo/base/expected.h"
#include "stereo/net/datagram.h"

namespace farshade {

/// Socket buffer size to request for each direction. The kernel may grant less (net.core.rmem_max).
inline constexpr int kSocketBuffer_bytes = 4 << 20;

struct UdpServer {
  std::unique_ptr<DatagramPort> port;  ///< its local() is the first address
  std::vector<Peer> addresses;         ///< where it listens, in the order given
};

/// Opens a port that listens on all `addresses` (`127.0.0.1:7447`, `[::]:0`, `name:port`), at least one, and
/// answers a datagram from the address that it came to. With port 0 the system chooses a port, another one
/// for each address; without a port it is kDefaultPort. `0.0.0.0` includes all addresses of IPv4, `[::]`
/// those of IPv6, too. Errors name the address: Malformed for a bad one and for two of which one includes the
/// other, whatever their ports; Missing for an unknown name or an address of another machine; Unavailable for
/// a port in use.
[[nodiscard]] Expected<UdpServer> listen_udp(std::span<const std::string> addresses);

/// The same for one address.
[[nodiscard]] Expected<std::unique_ptr<DatagramPort>> listen_udp(std::string_view address);

struct UdpClient {
  std::unique_ptr<DatagramPort> port;  ///< receives from `server` only
  Peer server;
};

/// The addresses to talk to that a name stands for, at least one, in the order in which the system prefers
/// them. Without a port it is kDefaultPort. It may wait for a name server.
[[nodiscard]] Expected<std::vector<Peer>> resolve_udp(std::string_view address);

/// Opens a port, chosen by the system, that talks to `server`. It sends nothing, so it does not know whether
/// somebody listens there.
[[nodiscard]] Expected<UdpClient> connect_udp(const Peer& server);

/// The same for the first address of a name.
[[nodiscard]] Expected<UdpClient> connect_udp(std::string_view address);

}  // namespace farshade
