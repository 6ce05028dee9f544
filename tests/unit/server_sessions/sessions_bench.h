/// SessionsBench: the server's sessions, and clients that exchange datagrams with them without a link.
#pragma once

#include "rt_server/sessions/sessions.h"
#include "tests/unit/link_client.h"

namespace farshade::sessions_bench {

using namespace link_test;

inline const std::vector<SharedKey> kRing{key_named("ada"), key_named("bob"), key_named("eve")};

inline constexpr Extent kSize{64, 64};

inline Peer peer(std::uint16_t port) {
  return Peer{{0, 1}, 0, port};
}

struct SessionsBench {
  explicit SessionsBench(const SessionLimits& limits = {}) : sessions(kServed, kRing, limits) {}

  Bytes say(std::uint16_t port, const Bytes& datagram, Time now = {}) {
    Bytes answer;
    taken = sessions.handle(peer(port), datagram, now, answer);
    EXPECT_TRUE(sessions.was_opened() || answer.size() <= datagram.size());
    return answer;
  }
  /// Sends `datagram` and the replies to the answers, until there is no reply.
  void talk(LinkClient& client, std::uint16_t port, Bytes datagram, Time now = {}) {
    while (!datagram.empty()) {
      const Bytes answer = say(port, datagram, now);
      if (answer.empty()) return;
      datagram = client.take(answer, now);
    }
  }
  LinkClient join(std::uint16_t port, Time now = {}, const SharedKey& key = kRing[0]) {
    LinkClient client(key, kServed);
    talk(client, port, client.hello(), now);
    return client;
  }
  void ask(LinkClient& client, std::uint16_t port, std::uint32_t frame, Time now = {}) {
    talk(client, port, client.seal({.request = request_of(frame, kSize)}), now);
  }

  Sessions sessions;
  Decoded<void> taken{};
};

}  // namespace farshade::sessions_bench
