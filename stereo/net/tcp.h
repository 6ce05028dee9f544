/// TCP streams for one thread each, whose calls always end: at a deadline, or soon after the caller wants to
/// stop. After a call that failed, a stream is of no further use, except that a read may be repeated that met
/// its deadline.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stereo/base/expected.h"
#include "stereo/net/datagram.h"

namespace farshade {

/// Until when a call may wait, on the steady clock. `stopped` is polled every kStopPoll; empty: never.
struct Waiting {
  Time until;
  std::function<bool()> stopped{};
};
inline constexpr Duration kStopPoll = std::chrono::milliseconds(50);

class TcpStream {
 public:
  struct State;
  explicit TcpStream(std::unique_ptr<State> state);
  TcpStream(TcpStream&&) noexcept;
  TcpStream& operator=(TcpStream&&) noexcept;
  TcpStream(const TcpStream&) = delete;
  TcpStream& operator=(const TcpStream&) = delete;
  ~TcpStream();

  [[nodiscard]] Peer peer() const;

  /// Waits for at least one byte. Errors: Missing if the other side closed or nothing came until the
  /// deadline.
  [[nodiscard]] Expected<std::size_t> read_some(std::span<std::byte> into, const Waiting& waiting);
  [[nodiscard]] Expected<void> write(std::span<const std::byte> bytes, const Waiting& waiting);

  /// Asks the system and the network to prefer other packets: traffic class CS1 (RFC 8325: background in
  /// Wi-Fi) and the queue for bulk traffic.
  void let_others_pass();

 private:
  std::unique_ptr<State> state_;
};

/// The addresses that a name stands for, at least one, in the order in which the system prefers them, with
/// its port, or `without_port`. It may wait for a name server.
[[nodiscard]] Expected<std::vector<Peer>> resolve_tcp(std::string_view address,
                                                      std::uint16_t without_port = kDefaultPort);

[[nodiscard]] Expected<TcpStream> connect_tcp(const Peer& server, const Waiting& waiting);

/// To the first of `servers`, at least one, that accepts. Each has an equal share of the time that is left.
/// The error names all that were tried.
[[nodiscard]] Expected<TcpStream> connect_tcp(std::span<const Peer> servers, const Waiting& waiting);

class TcpListener {
 public:
  /// With port 0 the system chooses a port. Errors, each with a cure: Unavailable if the port is in use,
  /// Missing for an address of another machine.
  [[nodiscard]] static Expected<TcpListener> listen(const Peer& address);
  /// Accepts from now on what connects to `other`, too.
  void join(TcpListener other);
  TcpListener(TcpListener&&) noexcept;
  TcpListener& operator=(TcpListener&&) noexcept;
  TcpListener(const TcpListener&) = delete;
  TcpListener& operator=(const TcpListener&) = delete;
  ~TcpListener();

  /// The first of its addresses.
  [[nodiscard]] Peer local() const;
  /// Nothing if nobody connected until the deadline. Its addresses take turns.
  [[nodiscard]] std::optional<TcpStream> accept(const Waiting& waiting);

 private:
  struct State;
  explicit TcpListener(std::unique_ptr<State> state);
  std::vector<std::unique_ptr<State>> states_;  ///< one for each address
  std::size_t next_ = 0;                        ///< address to look at first
};

struct TcpServer {
  TcpListener listener;
  std::vector<Peer> addresses;  ///< where it listens, in the order given
};

/// Listens on all `addresses`, at least one, as listen_udp does, with the same errors.
[[nodiscard]] Expected<TcpServer> listen_tcp(std::span<const std::string> addresses,
                                             std::uint16_t without_port = kDefaultPort);

}  // namespace farshade
