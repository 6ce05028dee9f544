/// Probe: how a server answers a hello, told apart. Shakes hands as a client would and then falls silent: the
/// server forgets it after some seconds, and a session that the same key has open stays as it is.
#pragma once

#include <optional>

#include "stereo/net/datagram.h"
#include "stereo/wire/handshake.h"

namespace farshade {

enum class ServerAnswer : std::uint8_t {
  Nothing,     ///< within the patience
  PortClosed,  ///< the machine answers that nobody listens there (ICMP)
  OtherVersion,
  UnknownKey,
  OtherScene,  ///< key and version are proved
  Busy,        ///< the same
  Welcomed,
};

struct Probed {
  ServerAnswer answer = ServerAnswer::Nothing;
  std::uint16_t version = kProtocolVersion;  ///< the server's
  ContentHash scene_hash{};                  ///< the server's, where key and version are proved
  std::optional<Duration> round_trip;        ///< of the hello that was answered last
};

/// Says hello to `server` every 250 ms until it answers or `patience` is over.
[[nodiscard]] Probed probe_server(DatagramPort& port, const Peer& server, const SharedKey& key,
                                  const ContentHash& scene_hash, Duration patience);

}  // namespace farshade
