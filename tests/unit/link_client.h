/// LinkClient: a minimal client for tests of the server. It shakes hands, seals, opens and assembles, and
/// keeps everything it receives. It has no socket and no clock, and sends only what a test tells it to send.
#pragma once

#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "rt_server/work/server_core.h"
#include "stereo/answers/assembler.h"
#include "stereo/net/arrivals.h"
#include "stereo/sealing/handshake.h"
#include "tests/unit/answers_from.h"

namespace farshade::link_test {

using Bytes = std::vector<std::byte>;

inline SharedKey key_named(std::string name) {
  SharedKey key{.name = std::move(name)};
  for (std::size_t i = 0; i < key.name.size(); ++i) key.secret[i] = static_cast<std::uint8_t>(key.name[i]);
  key.secret.back() = 1;
  return key;
}

inline const Welcome kServed{{1, 2, 3}, 3};  ///< a scene with three lights
inline const SharedKey kKey = key_named("ada");

inline FrameRequest request_of(std::uint32_t frame, Extent size) {
  FrameRequest request;
  request.frame = {frame};
  for (View& view : request.views) view = {{}, {-0.7, 0.8, 0.6, -0.5}, size};
  return request;
}

struct LinkClient {
  LinkClient(SharedKey client_key, const Welcome& served, ProtocolVersion protocol = kProtocolVersion)
      : key(std::move(client_key)),
        scene(served),
        version(protocol),
        handshake(key, served.scene_hash, protocol) {}

  [[nodiscard]] Bytes hello() const {
    Bytes datagram;
    handshake.write_hello(datagram);
    return datagram;
  }
  /// A sealed request. The assembler expects its masks.
  Bytes ask(const FrameRequest& request) {
    assembler.expect(request, {scene.light_count}, request.lights.revision);
    return seal({.request = request, .probe_echo = probe, .arrivals = arrivals.report()});
  }
  Bytes seal(const RequestMessage& message) {
    Bytes bytes, datagram;
    encode(ClientMessage(message), bytes, version);
    sealer->seal(bytes, datagram);
    return datagram;
  }

  /// Processes a datagram. Returns the reply: the hello with the cookie of a retry, or nothing.
  Bytes take(std::span<const std::byte> datagram, Time arrived) {
    const Decoded<ServerEnvelope> envelope = open_server_envelope(datagram);
    if (!envelope) {
      refused.count(envelope.error());
    } else if (const auto* no = std::get_if<OpenRefusal>(&*envelope)) {
      open_refusal = *no;
    } else if (std::visit([](const auto& any) { return any.version; }, *envelope) != version) {
      refused.count(WireRefusal::Version);
    } else if (const auto* sealed = std::get_if<Sealed>(&*envelope)) {
      take_sealed(*sealed, datagram, arrived);
    } else if (const auto* retry = std::get_if<Retry>(&*envelope)) {
      if (handshake.take(*retry)) return hello();
    } else if (const auto* accept = std::get_if<Accept>(&*envelope)) {
      take_accept(*accept, datagram);
    } else {
      ++no_session;
    }
    return {};
  }

  SharedKey key;
  Welcome scene;
  ProtocolVersion version;
  ClientHandshake handshake;
  std::optional<SessionId> session{};
  std::optional<SessionKeys> keys{};
  std::optional<Sealer> sealer{};
  std::optional<Opener> opener{};
  Arrivals arrivals{};
  Assembler assembler{};
  std::uint64_t probe = 0;  ///< the newest token; a test may reset it to 0
  std::optional<Welcome> welcome{};
  std::optional<Refusal> refusal{};
  std::optional<OpenRefusal> open_refusal{};
  std::uint64_t slices = 0, reports = 0, probes = 0, no_session = 0;
  std::optional<FrameReport> report{};
  RefusalCounts refused{};

 private:
  void take_accept(const Accept& accept, std::span<const std::byte> datagram) {
    const auto completed = handshake.take(accept, datagram);
    if (!completed || session == completed->keys.session) return;
    if (const auto* no = std::get_if<Refusal>(&completed->answer)) {
      refusal = *no;
      return;
    }
    welcome = std::get<Welcome>(completed->answer);
    session = completed->keys.session;
    keys = completed->keys;
    sealer.emplace(completed->keys.session, completed->keys.to_server, completed->keys.sealing,
                   completed->keys.version);
    opener.emplace(completed->keys.to_client, completed->keys.sealing);
  }
  void take_sealed(const Sealed& sealed, std::span<const std::byte> datagram, Time arrived) {
    if (session != sealed.session) return refused.count(WireRefusal::UnknownSession);
    Bytes message;
    const auto opened = opener->open(sealed, datagram, message);
    if (!opened) return refused.count(opened.error());
    arrivals.add(sealed.counter, arrived);
    const Decoded<ServerMessage> said = decode_server(*opened, version);
    ASSERT_TRUE(said.has_value()) << name_of(said.error());
    if (const auto* slice = std::get_if<Slice>(&*said)) {
      ++slices;
      assembler.accept(*slice);
    } else if (const auto* told = std::get_if<FrameReport>(&*said)) {
      ++reports;
      report = *told;
      assembler.accept(*told);
    } else if (const auto* new_probe = std::get_if<Probe>(&*said)) {
      ++probes;
      probe = new_probe->token;
    }
  }
};

/// A LinkClient on a port.
struct PortClient : LinkClient {
  PortClient(DatagramPort& own, const Peer& to, SharedKey client_key, const Welcome& served,
             ProtocolVersion protocol = kProtocolVersion)
      : LinkClient(std::move(client_key), served, protocol), port(own), server(to) {}

  void say(const Bytes& datagram) { port.send(server, datagram); }
  /// Receives one datagram and replies. Returns false if none came.
  bool hear(Duration wait) {
    std::array<std::byte, kMaxDatagram_bytes> buffer;
    const auto datagram = port.receive(buffer, wait);
    if (!datagram) return false;
    if (const Bytes reply = take(datagram->bytes, datagram->arrived); !reply.empty()) say(reply);
    return true;
  }
  /// Shakes hands. Returns false if there is no session after `patience`.
  bool connect(Duration patience) {
    say(hello());
    while (!session && hear(patience)) {
    }
    return session.has_value();
  }

  DatagramPort& port;
  Peer server;
};

/// Lets a server in virtual time do everything that it can do now.
inline void serve(ServerCore& core) {
  while (core.receive(Duration::zero())) {
  }
  while (core.work()) {
  }
  core.send_due();
}

}  // namespace farshade::link_test
