#include <gtest/gtest.h>

#include <map>

#include "tests/unit/link_client.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;
using namespace link_test;

const Peer kHome{{0, 1}, 0, 1}, kAway{{0, 2}, 0, 1}, kThief{{0, 3}, 0, 1};

/// A client with a session and the address kHome.
struct Moving : testing::Test {
  Moving() {
    say(kHome, client.hello());
    proved = kHome;
    ask(kHome);
  }
  void say(const Peer& from, Bytes datagram) {
    while (!datagram.empty()) {
      Bytes answer;
      const bool was_proved = from == proved;
      const std::uint64_t moved = sessions.counters().moved;
      (void)sessions.handle(from, datagram, now, answer);
      EXPECT_TRUE(was_proved || answer.size() <= datagram.size());
      if (sessions.counters().moved != moved) proved = from;
      sent_to[from] += answer.size();
      got_from[from] += datagram.size();
      received = answer;
      datagram = from == kThief || answer.empty() ? Bytes() : client.take(answer, now);
    }
  }
  Bytes next_request() {
    now += 14ms;
    return client.seal({.request = request_of(++frame, {64, 64}), .probe_echo = client.probe});
  }
  void ask(const Peer& from) { say(from, next_request()); }
  /// The address to which the slices of the newest request are sent.
  Peer slices_go_to() {
    const auto job = sessions.next_job(now);
    EXPECT_TRUE(job.has_value());
    if (!job) return {};
    EXPECT_EQ(job->request.frame, FrameId{frame});
    const std::vector<Bytes> messages(3, Bytes(500, std::byte{9}));
    sessions.put(job->session, messages, {}, now);
    now += 1s;
    Peer to;
    for (Bytes datagram; sessions.seal_due(now, to, datagram);) {
    }
    return to;
  }

  Sessions sessions{kServed, {kKey}};
  LinkClient client{kKey, kServed};
  Time now{};
  std::uint32_t frame = 0;
  std::optional<Peer> proved;  ///< the client's address
  Bytes received;
  std::map<Peer, std::size_t> sent_to, got_from;
};
using SessionAddress = Moving;

TEST_F(SessionAddress, IsTakenWhenItHasEchoedItsProbe) {
  EXPECT_EQ(slices_go_to(), kHome);
  ask(kAway);
  EXPECT_EQ(client.probes, 1u);
  EXPECT_EQ(slices_go_to(), kHome);
  ask(kAway);
  EXPECT_EQ(slices_go_to(), kAway);
  EXPECT_EQ(sessions.counters().moved, 1u);
  EXPECT_EQ(sessions.size(), 1u);
  EXPECT_LE(sent_to[kAway], got_from[kAway]);
}

TEST_F(SessionAddress, DoesNotMoveToAThiefThatReplaysADatagramFirst) {
  for (int i = 0; i < 20; ++i) {
    const Bytes caught = next_request();
    say(kThief, caught);  // before the server has received it from the client
    EXPECT_EQ(sessions.counters().moved, 0u);
    const Bytes probe = received;
    say(kHome, caught);
    say(kThief, probe);  // unchanged: the token is sealed
    EXPECT_EQ(slices_go_to(), kHome);
    ask(kHome);
    EXPECT_EQ(slices_go_to(), kHome);
  }
  EXPECT_EQ(sessions.counters().moved, 0u);
  EXPECT_GT(sent_to[kThief], 0u);
  EXPECT_LE(sent_to[kThief], got_from[kThief]);
}

/// A thief that intercepts datagrams can make the client return the token: it forwards the server's probe.
/// That must not help the thief after the server has received a datagram from the client's own address.
TEST_F(SessionAddress, ADatagramFromTheKnownAddressEndsTheCandidacyOfAnother) {
  say(kThief, next_request());  // intercepted: never reaches the server from home
  client.take(received, now);   // the probe, forwarded
  ASSERT_EQ(client.probes, 1u);
  ask(kHome);
  say(kThief, next_request());  // intercepted, with the token
  EXPECT_EQ(sessions.counters().moved, 0u);
  EXPECT_EQ(slices_go_to(), kHome);
}

/// A keep-alive goes to the known address. If it carried the candidate's token, the client would return it.
TEST_F(SessionAddress, KeepAliveDoesNotCarryTheTokenOfACandidate) {
  const Bytes late = next_request();
  say(kThief, next_request());  // intercepted: the thief becomes a candidate
  now += 1s;
  say(kHome, late);  // older, so the thief remains the candidate
  ASSERT_EQ(client.probes, 1u) << "the keep-alive";
  say(kThief, next_request());  // intercepted, with the content of the keep-alive
  EXPECT_EQ(sessions.counters().moved, 0u);
}

TEST_F(SessionAddress, ANewCandidateGetsANewToken) {
  ask(kAway);
  const std::uint64_t first = client.probe;
  ask(Peer{{0, 4}, 0, 1});
  EXPECT_NE(client.probe, first);
  EXPECT_EQ(sessions.counters().moved, 0u);
}

TEST_F(SessionAddress, TokenOfOneAddressMovesNothingToAnother) {
  ask(kAway);
  ASSERT_EQ(client.probes, 1u);
  const Bytes with_token = next_request();
  say(kThief, with_token);
  EXPECT_EQ(sessions.counters().moved, 0u);
  EXPECT_EQ(slices_go_to(), kHome);
}

TEST_F(SessionAddress, OldDatagramsFromTheOldAddressDoNotBringItBack) {
  const Bytes late = next_request();
  ask(kAway);
  ask(kAway);
  EXPECT_EQ(sessions.counters().moved, 1u);
  say(kHome, late);
  ask(kAway);
  EXPECT_EQ(slices_go_to(), kAway);
  EXPECT_EQ(sessions.counters().moved, 1u);
  EXPECT_EQ(client.probes, 1u);
}

TEST_F(SessionAddress, FollowsAClientThatMovesEachSecond) {
  for (std::uint16_t port = 2; port < 50; ++port) {
    const Peer here{{0, 9}, 0, port};
    ask(here);
    ask(here);
    EXPECT_EQ(slices_go_to(), here);
  }
  EXPECT_EQ(sessions.counters().moved, 48u);
  EXPECT_EQ(sessions.size(), 1u);
}

/// What was learned about one path says nothing about another.
TEST_F(SessionAddress, ANewAddressBeginsWithTheRateOfANewSession) {
  double rate = 0;
  for (int i = 0; i < 400; ++i) {
    now += 14ms;
    RequestMessage message{.request = request_of(++frame, {64, 64}), .arrivals = client.arrivals.report()};
    say(kHome, client.seal(message));
    if (const auto job = sessions.next_job(now)) {
      rate = job->bytes_per_second;
      sessions.put(job->session, std::vector<Bytes>(12, Bytes(1000, std::byte{9})), {}, now);
    }
    Peer to;
    for (Bytes datagram; sessions.seal_due(now + 13ms, to, datagram);)
      client.arrivals.add(std::get<Sealed>(*open_server_envelope(datagram)).counter, now + i * 2ms);
  }
  ASSERT_LT(rate, 0.5 * RateControl::kStart) << "a queue that grows by 2 ms in each frame";
  for (int i = 0; i < 3; ++i) ask(kAway);
  now += 5s;
  Peer to;
  for (Bytes datagram; sessions.seal_due(now, to, datagram);) {
  }
  EXPECT_EQ(to, kAway);
  now += 1s;
  ask(kAway);
  const auto job = sessions.next_job(now);
  ASSERT_TRUE(job.has_value());
  EXPECT_EQ(job->bytes_per_second, RateControl::kStart);
}

/// A probe of the path is longer than the datagram that it answers.
TEST_F(SessionAddress, AnOldDatagramFromElsewhereGetsNoProbeOfThePath) {
  now += 200ms;
  ask(kHome);
  ASSERT_EQ(client.probes, 1u) << "a keep-alive, whose arrival begins the search of the path";
  const Bytes old = next_request();
  say(kHome, client.seal({.request = request_of(++frame, {64, 64}), .arrivals = client.arrivals.report()}));
  EXPECT_GT(received.size(), kBaseDatagram_bytes);
  now += PathMtu::kProbeTimer;
  say(kThief, old);
  EXPECT_TRUE(received.empty());
  EXPECT_EQ(sent_to[kThief], 0u);
  ask(kHome);  // its answer is a keep-alive
  ask(kHome);
  EXPECT_GT(received.size(), kBaseDatagram_bytes) << "a probe was due";
}

TEST_F(SessionAddress, ANewAddressBeginsWithDatagramsOfTheBase) {
  const auto most_after = [&](const Peer& from) {
    now += 14ms;
    say(from, client.seal({.request = request_of(++frame, {64, 64}),
                           .probe_echo = client.probe,
                           .arrivals = client.arrivals.report()}));
    const auto job = sessions.next_job(now);
    EXPECT_TRUE(job.has_value());
    if (!job) return std::size_t{0};
    sessions.put(job->session, std::vector<Bytes>(1, Bytes(100, std::byte{9})), {}, now);
    Peer to;
    for (Bytes datagram; sessions.seal_due(now, to, datagram);)
      client.arrivals.add(std::get<Sealed>(*open_server_envelope(datagram)).counter, now);
    return job->most_message_bytes;
  };
  EXPECT_EQ(most_after(kHome), kBaseMessage_bytes);
  for (int i = 0; i < 5; ++i) most_after(kHome);
  EXPECT_EQ(most_after(kHome), kMaxMessage_bytes);
  EXPECT_EQ(most_after(kAway), kMaxMessage_bytes) << "that address is not proved yet";
  EXPECT_EQ(most_after(kAway), kBaseMessage_bytes);
  EXPECT_EQ(sessions.counters().moved, 1u);
  for (int i = 0; i < 5; ++i) most_after(kAway);
  EXPECT_EQ(most_after(kAway), kMaxMessage_bytes) << "the new path is searched";
}

}  // namespace
}  // namespace farshade
