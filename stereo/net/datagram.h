/// The datagram seam: the one place where bytes leave and reach a program. Real UDP (udp.h), UDP behind a bad
/// network (impaired_port.h) and an in-process link in virtual time (virtual_link.h) are behind it;
/// everything above works over any of them.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "stereo/base/clock.h"

namespace farshade {

/// An address that datagrams come from and go to; a value to compare and to key by, nothing to look into.
struct Peer {
  std::array<std::uint8_t, 16> address{};  ///< IPv6, or IPv4 mapped into it (RFC 4291, 2.5.5.2)
  std::uint32_t scope = 0;                 ///< interface of an IPv6 link-local address, else 0
  std::uint16_t port = 0;
  friend auto operator<=>(const Peer&, const Peer&) = default;
};

/// `127.0.0.1:7447` or `[::1]:7447`.
[[nodiscard]] std::string to_string(const Peer& peer);

/// An address that no other machine can reach: 127.0.0.0/8 or ::1.
[[nodiscard]] bool is_loopback(const Peer& peer);

struct Datagram {
  Peer from;
  std::span<const std::byte> bytes;  ///< in the buffer that the receiver gave
  /// When it reached this machine, however late it is read: on the steady clock (SteadyClock), over a virtual
  /// link on the link's.
  Time arrived{};
};

struct PortCounters {
  std::uint64_t sent = 0, sent_bytes = 0;
  std::uint64_t received = 0, received_bytes = 0;
  std::uint64_t unsent = 0;     ///< the socket had no room or the network no way: dropped on this side
  std::uint64_t oversized = 0;  ///< came longer than the receiver's buffer, dropped
  std::uint64_t strangers = 0;  ///< came from another address than the one this port talks to, dropped
  friend bool operator==(const PortCounters&, const PortCounters&) = default;
};

/// Sends and receives datagrams of at most kMaxDatagram_bytes (stereo/wire/messages.h) and allocates nothing.
/// One thread may receive while another sends; wake and counters may be called from any thread.
class DatagramPort {
 public:
  virtual ~DatagramPort() = default;

  /// Where datagrams to this port go.
  [[nodiscard]] virtual Peer local() const = 0;

  /// Hands `bytes` to the network and never blocks. False: dropped on this side, counted as unsent.
  virtual bool send(const Peer& to, std::span<const std::byte> bytes) = 0;

  /// The next datagram, copied to `into`; waits for one at most `wait` (0 polls). Nothing at the end of the
  /// wait or when woken. Errors of earlier sends (ICMP) never show here.
  [[nodiscard]] virtual std::optional<Datagram> receive(std::span<std::byte> into, Duration wait) = 0;

  /// Ends the receive that waits now, or else the next one that would.
  virtual void wake() = 0;

  [[nodiscard]] virtual PortCounters counters() const = 0;
};

}  // namespace farshade

template <>
struct std::hash<farshade::Peer> {
  std::size_t operator()(const farshade::Peer& peer) const noexcept;
};
