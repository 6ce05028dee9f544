/// DatagramPort: the interface through which a program sends and receives datagrams. It is implemented by UDP
/// (udp.h), by UDP with simulated impairments (impaired_port.h) and, in tests, by a link in virtual time.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <tuple>

#include "stereo/base/clock.h"

namespace farshade {

/// An address of a datagram's sender or receiver.
struct Peer {
  std::array<std::uint8_t, 16> address{};  ///< IPv6, or IPv4 mapped into it (RFC 4291, 2.5.5.2)
  std::uint32_t scope = 0;                 ///< interface of an IPv6 link-local address, otherwise 0
  std::uint16_t port = 0;
  /// The own address that its datagrams come to, from which it is answered; all zero: the system chooses. It
  /// does not tell peers apart.
  std::array<std::uint8_t, 16> via{};
  friend bool operator==(const Peer& a, const Peer& b) {
    return std::tie(a.address, a.scope, a.port) == std::tie(b.address, b.scope, b.port);
  }
  friend auto operator<=>(const Peer& a, const Peer& b) {
    return std::tie(a.address, a.scope, a.port) <=> std::tie(b.address, b.scope, b.port);
  }
};

/// The port of a server whose address names none, for UDP and TCP.
inline constexpr std::uint16_t kDefaultPort = 7447;

/// `127.0.0.1:7447` or `[::1]:7447`.
[[nodiscard]] std::string to_string(const Peer& peer);

/// Whether no other machine can reach the address: 127.0.0.0/8 or ::1.
[[nodiscard]] bool is_loopback(const Peer& peer);

/// Whether both have one IPv4 address, or IPv6 addresses of one /64: whoever has one of those has all of them
/// (RFC 4291, 2.5.4).
[[nodiscard]] bool is_of_one_network(const Peer& a, const Peer& b);

/// Whether the address is one of IPv4.
[[nodiscard]] bool is_v4(const Peer& peer);

/// Whether a port with this address listens on all addresses of its machine: 0.0.0.0 or [::].
[[nodiscard]] bool is_unspecified(const Peer& peer);

struct Datagram {
  Peer from;
  std::span<const std::byte> bytes;  ///< in the receiver's buffer
  /// When it reached this machine, even if it is read later. On the steady clock (SteadyClock); over a
  /// virtual link, on the link's clock.
  Time arrived{};
};

struct PortCounters {
  std::uint64_t sent = 0, sent_bytes = 0;
  std::uint64_t received = 0, received_bytes = 0;
  std::uint64_t unsent =
      0;  ///< dropped on this side: no room in the socket, no route, or longer than the interface takes
  std::uint64_t oversized = 0;  ///< dropped: longer than the receiver's buffer
  std::uint64_t strangers = 0;  ///< dropped: from an address that this port does not talk to
  friend bool operator==(const PortCounters&, const PortCounters&) = default;
};

/// Sends and receives datagrams of at most kMaxDatagram_bytes (stereo/messages/messages.h). Allocates
/// nothing. One thread may receive while another sends. Any thread may call wake and counters.
class DatagramPort {
 public:
  virtual ~DatagramPort() = default;

  /// The address of this port.
  [[nodiscard]] virtual Peer local() const = 0;

  /// Sends `bytes` without blocking. False: they were dropped on this side and counted as unsent.
  virtual bool send(const Peer& to, std::span<const std::byte> bytes) = 0;

  /// Waits at most `wait` (0 polls) for a datagram and copies it to `into`. Returns nothing after the wait,
  /// or when woken. Errors of earlier sends (ICMP) have no effect here.
  [[nodiscard]] virtual std::optional<Datagram> receive(std::span<std::byte> into, Duration wait) = 0;

  /// Ends the receive that waits now, or otherwise the next one that would wait.
  virtual void wake() = 0;

  [[nodiscard]] virtual PortCounters counters() const = 0;
};

}  // namespace farshade

template <>
struct std::hash<farshade::Peer> {
  std::size_t operator()(const farshade::Peer& peer) const noexcept;
};
