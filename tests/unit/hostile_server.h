/// HostileServer: a server that holds the key of its client and sends whatever a test or a fuzz target wants.
/// It shakes hands without a cookie, and seals with any counter. It has no clock.
#pragma once

#include <optional>
#include <vector>

#include "stereo/net/datagram.h"
#include "tests/unit/forged.h"

namespace farshade::link_test {

class HostileServer {
 public:
  /// Keeps a reference to `port`.
  HostileServer(DatagramPort& port, SharedKey key, const Welcome& welcome)
      : port_(port), key_(std::move(key)), welcome_(welcome) {}

  /// Takes all datagrams that have arrived. Answers each hello with a new session.
  void serve() {
    std::array<std::byte, kMaxDatagram_bytes> buffer;
    while (const auto datagram = port_.receive(buffer, Duration::zero())) {
      const Decoded<ClientEnvelope> envelope = open_client_envelope(datagram->bytes);
      if (!envelope) continue;
      if (const auto* hello = std::get_if<Hello>(&*envelope)) connect(*hello, *datagram);
      if (const auto* sealed = std::get_if<Sealed>(&*envelope)) open(*sealed, *datagram);
    }
  }

  /// Sends a message, or bytes that are none, with the next counter or with `counter`. Later ones follow it,
  /// unless the client refuses such a jump.
  void say(std::span<const std::byte> message, std::optional<std::uint64_t> counter = {}) {
    if (!keys_) return;
    const std::uint64_t used = counter.value_or(next_);
    port_.send(client_, seal_at(used, keys_->session, keys_->to_client, message));
    const std::uint64_t newest = next_ == 0 ? 0 : next_ - 1;
    if (used >= next_ && used - newest <= ReplayWindow::kMostJump) next_ = used + 1;
  }
  void say(const ServerMessage& message, std::optional<std::uint64_t> counter = {}) {
    std::vector<std::byte> bytes;
    encode(message, bytes);
    say(bytes, counter);
  }
  [[nodiscard]] bool has_session() const { return keys_.has_value(); }
  /// The newest request that came.
  [[nodiscard]] const std::optional<RequestMessage>& request() const { return request_; }
  [[nodiscard]] std::uint64_t requests() const { return requests_; }
  /// The number of sessions that it has begun.
  [[nodiscard]] std::uint64_t sessions() const { return sessions_; }

 private:
  void connect(const Hello& hello, const Datagram& datagram) {
    const std::optional<Accepted> accepted = accept(hello, datagram.bytes, key_, welcome_);
    if (!accepted) return;
    keys_ = accepted->keys;
    opener_.emplace(keys_->to_server, keys_->sealing);
    client_ = datagram.from;
    next_ = 0;
    ++sessions_;
    port_.send(client_, accepted->datagram);
  }
  void open(const Sealed& sealed, const Datagram& datagram) {
    std::vector<std::byte> bytes;
    if (!opener_) return;
    const auto opened = opener_->open(sealed, datagram.bytes, bytes);
    if (!opened) return;
    const Decoded<ClientMessage> message = decode_client(*opened);
    if (!message || !std::holds_alternative<RequestMessage>(*message)) return;
    request_ = std::get<RequestMessage>(*message);
    ++requests_;
  }

  DatagramPort& port_;
  SharedKey key_;
  Welcome welcome_;
  std::optional<SessionKeys> keys_;
  std::optional<Opener> opener_;
  Peer client_;
  std::uint64_t next_ = 0, requests_ = 0, sessions_ = 0;
  std::optional<RequestMessage> request_;
};

}  // namespace farshade::link_test
