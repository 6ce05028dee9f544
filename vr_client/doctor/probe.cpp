#include "vr_client/doctor/probe.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace farshade {
namespace {

constexpr Duration kHelloInterval = std::chrono::milliseconds(250);
/// How long the server may take to contradict somebody who refuses us in its name.
constexpr Duration kHearsayPatience = std::chrono::milliseconds(500);
constexpr int kIcmpPatience_ms = 500;

/// One handshake under way.
class Attempt {
 public:
  Attempt(DatagramPort& port, const Peer& server, const SharedKey& key, const ContentHash& scene_hash)
      : port_(port), server_(server), handshake_(key, scene_hash) {}

  void say_hello() {
    handshake_.write_hello(hello_);
    said_ = clock_.now();
    port_.send(server_, hello_);
  }

  /// Takes in what comes until `until`; true once the server has proved itself.
  bool listen(Time until) {
    const std::optional<Datagram> datagram = port_.receive(incoming_, until - clock_.now());
    if (!datagram) return false;
    const Decoded<ServerEnvelope> envelope = open_server_envelope(datagram->bytes);
    if (!envelope) return false;
    if (const auto* retry = std::get_if<Retry>(&*envelope)) {
      if (handshake_.take(*retry)) say_hello();
    } else if (const auto* refusal = std::get_if<OpenRefusal>(&*envelope)) {
      if (refusal->echo == handshake_.echo()) take(*refusal, datagram->arrived);
    } else if (const auto* accept = std::get_if<Accept>(&*envelope)) {
      const auto met = handshake_.take(*accept, datagram->bytes);
      if (met) take(*met, datagram->arrived);
      return met.has_value();
    }
    return false;
  }

  [[nodiscard]] const Probed& probed() const { return probed_; }

 private:
  void take(const OpenRefusal& refusal, Time arrived) {
    probed_.answer = refusal.reason == RefusalReason::VersionMismatch ? ServerAnswer::OtherVersion
                                                                      : ServerAnswer::UnknownKey;
    probed_.version = refusal.version;
    probed_.round_trip = arrived - said_;
  }

  void take(const ClientHandshake::Met& met, Time arrived) {
    probed_ = {.answer = ServerAnswer::Welcomed, .round_trip = arrived - said_};
    if (const auto* welcome = std::get_if<Welcome>(&met.answer)) probed_.scene_hash = welcome->scene_hash;
    const auto* refusal = std::get_if<Refusal>(&met.answer);
    if (!refusal) return;
    probed_.scene_hash = refusal->scene_hash;
    probed_.answer = refusal->reason == RefusalReason::Busy ? ServerAnswer::Busy : ServerAnswer::OtherScene;
  }

  SteadyClock clock_;
  DatagramPort& port_;
  Peer server_;
  ClientHandshake handshake_;
  Probed probed_;
  Time said_{};
  std::vector<std::byte> hello_;
  std::array<std::byte, kMaxDatagram_bytes> incoming_{};
};

/// Only a connected socket is told what ICMP says, and our ports are not (udp.h): one more is asked.
bool is_port_closed(const Peer& peer) {
  sockaddr_in6 wide{.sin6_family = AF_INET6,
                    .sin6_port = htons(peer.port),
                    .sin6_flowinfo = 0,
                    .sin6_addr = {},
                    .sin6_scope_id = peer.scope};
  std::memcpy(&wide.sin6_addr, peer.address.data(), peer.address.size());
  sockaddr_in slim{.sin_family = AF_INET, .sin_port = wide.sin6_port, .sin_addr = {}, .sin_zero = {}};
  std::memcpy(&slim.sin_addr, peer.address.data() + 12, 4);
  const bool is_v4 = IN6_IS_ADDR_V4MAPPED(&wide.sin6_addr);
  const auto* address =
      is_v4 ? reinterpret_cast<const sockaddr*>(&slim) : reinterpret_cast<const sockaddr*>(&wide);
  const int file = ::socket(is_v4 ? AF_INET : AF_INET6, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (file < 0) return false;
  bool closed = false;
  if (::connect(file, address, is_v4 ? sizeof slim : sizeof wide) == 0 && ::send(file, "?", 1, 0) == 1) {
    pollfd watched{file, POLLIN, 0};
    char byte = 0;
    closed = ::poll(&watched, 1, kIcmpPatience_ms) > 0 && ::recv(file, &byte, 1, MSG_DONTWAIT) < 0 &&
             errno == ECONNREFUSED;
  }
  ::close(file);
  return closed;
}

}  // namespace

Probed probe_server(DatagramPort& port, const Peer& server, const SharedKey& key,
                    const ContentHash& scene_hash, Duration patience) {
  const SteadyClock clock;
  Attempt attempt(port, server, key, scene_hash);
  Time until = clock.now() + patience;
  while (clock.now() < until) {
    attempt.say_hello();
    const Time again = std::min(until, clock.now() + kHelloInterval);
    while (clock.now() < again) {
      const bool knew = attempt.probed().answer != ServerAnswer::Nothing;
      if (attempt.listen(again)) return attempt.probed();
      if (!knew && attempt.probed().answer != ServerAnswer::Nothing)
        until = std::min(until, clock.now() + kHearsayPatience);
    }
  }
  Probed probed = attempt.probed();
  if (probed.answer == ServerAnswer::Nothing && is_port_closed(server))
    probed.answer = ServerAnswer::PortClosed;
  return probed;
}

}  // namespace farshade
