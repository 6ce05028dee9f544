#include "rt_server/admission/gate.h"

#include <gtest/gtest.h>

#include "tests/support/watched_sodium.h"
#include "tests/unit/messages/samples.h"

namespace farshade {
namespace {

using namespace wire_samples;

constexpr Time kStart = time_from_ns(1'000'000'000'000);

SharedKey key_of(std::string name, unsigned first_byte) {
  return {.name = std::move(name), .secret = counting<32>(first_byte)};
}

Peer peer(std::uint8_t last, std::uint16_t port) {
  Peer from{.address = {}, .port = port};
  from.address[15] = last;
  return from;
}
const Peer kFrom = peer(1, 4000);

struct Client {
  ClientHandshake handshake;
  explicit Client(const SharedKey& key = shared_key()) : handshake(key, counting_hash()) {}

  [[nodiscard]] Bytes hello() const {
    Bytes datagram;
    handshake.write_hello(datagram);
    return datagram;
  }
};

struct GateTest : testing::Test {
  /// A key that has used its own handshakes, and may have many of the ten that both share.
  GateTest() {
    of_key.own = TokenBucket(1e-9);
    of_key.own.take();
  }

  Gate gate{{shared_key(), key_of("lap", 100)}, 20};
  KeyHandshakes of_key{1000, 2};
  Bytes answer;

  const SharedKey* knock(const Bytes& hello, Time now, const Peer& from = kFrom) {
    answer.clear();
    const SharedKey* key =
        gate.admit(from, std::get<Hello>(*open_client_envelope(hello)), hello, now, answer);
    EXPECT_LE(answer.size(), hello.size());
    EXPECT_EQ(key == nullptr, !answer.empty());
    return key;
  }
  const SharedKey* knock(const Client& client, Time now, const Peer& from = kFrom) {
    return knock(client.hello(), now, from);
  }

  [[nodiscard]] ServerEnvelope said() const { return *open_server_envelope(answer); }
  [[nodiscard]] bool says_retry() const { return std::holds_alternative<Retry>(said()); }

  /// A client with a cookie made at `now` for `from`.
  Client with_cookie(Time now, const Peer& from = kFrom, const SharedKey& key = shared_key()) {
    Client client(key);
    EXPECT_EQ(knock(client, now, from), nullptr);
    EXPECT_TRUE(client.handshake.take(std::get<Retry>(said())));
    return client;
  }
};

TEST_F(GateTest, AnswersAStrangerWithACookie) {
  const Client client;
  EXPECT_EQ(knock(client, kStart), nullptr);
  const auto retry = std::get<Retry>(said());
  EXPECT_EQ(retry.echo, client.handshake.echo());
  EXPECT_NE(retry.cookie, Cookie{});
  EXPECT_EQ(gate.counters(), (GateCounters{.retries = 1}));
}

TEST_F(GateTest, AdmitsAClientWithCookieAndKey) {
  EXPECT_EQ(knock(with_cookie(kStart), kStart)->name, "desk");
  EXPECT_EQ(knock(with_cookie(kStart, kFrom, key_of("any", 100)), kStart)->name, "lap");
  EXPECT_EQ(gate.counters(), (GateCounters{.retries = 2}));
}

TEST_F(GateTest, BindsACookieToAddressScopePortAndPublicKey) {
  const Client client = with_cookie(kStart);
  Peer elsewhere = kFrom;
  for (std::uint8_t& byte : elsewhere.address) {
    byte ^= 1;
    EXPECT_EQ(knock(client, kStart, elsewhere), nullptr);
    EXPECT_TRUE(says_retry());
    byte ^= 1;
  }
  elsewhere.scope = 1;
  EXPECT_EQ(knock(client, kStart, elsewhere), nullptr);
  EXPECT_TRUE(says_retry());
  EXPECT_EQ(knock(client, kStart, peer(1, 4001)), nullptr);
  EXPECT_TRUE(says_retry());

  Client other;
  const Cookie theirs = std::get<Hello>(*open_client_envelope(client.hello())).cookie;
  ASSERT_TRUE(other.handshake.take(Retry{other.handshake.echo(), theirs}));
  EXPECT_EQ(knock(other, kStart), nullptr);
  EXPECT_TRUE(says_retry());
  EXPECT_TRUE(knock(client, kStart));
}

TEST_F(GateTest, CookiesHoldTwoToFourSeconds) {
  for (int i = 0; i < 40; ++i) {
    const Time made = kStart + i * std::chrono::milliseconds(100);
    const Client client = with_cookie(made);
    EXPECT_TRUE(knock(client, made + kCookiePeriod)) << i;
    EXPECT_FALSE(knock(client, made + kCookieLife)) << i;
    EXPECT_TRUE(says_retry());
    EXPECT_FALSE(knock(client, made - kCookiePeriod)) << "made in the future";
    EXPECT_FALSE(knock(client, made + std::chrono::hours(1))) << i;
  }
  EXPECT_EQ(kCookieLife, std::chrono::seconds(4));
}

TEST_F(GateTest, CookiesAreInvalidInAnotherProcess) {
  const Client client = with_cookie(kStart);
  gate = Gate({shared_key()}, 10);
  EXPECT_EQ(knock(client, kStart), nullptr);
  EXPECT_TRUE(says_retry());
}

TEST_F(GateTest, EveryFlippedBitOfACookieGetsARetry) {
  const Bytes hello = with_cookie(kStart).hello();
  for (std::size_t bit = 0; bit < 128; ++bit) {
    Bytes flipped = hello;
    flipped[79 + bit / 8] ^= std::byte{1} << bit % 8;
    EXPECT_EQ(knock(flipped, kStart), nullptr);
    EXPECT_TRUE(says_retry()) << bit;
  }
}

/// A hello without a cookie is compared with the cookies of this period and the last one.
TEST_F(GateTest, ComparesACookieInATimeThatDoesNotTellWhereItDiffers) {
  if (!WatchedSodium::is_possible()) GTEST_SKIP() << "libsodium is a static library";
  const Client known = with_cookie(kStart), stranger;
  const WatchedSodium watched;
  EXPECT_TRUE(knock(known, kStart));
  EXPECT_FALSE(knock(stranger, kStart));
  constexpr std::size_t kCookie = sizeof(Cookie), kProof = sizeof Hello::proof;
  EXPECT_EQ(watched.compared, (std::vector{kCookie, kProof, kCookie, kCookie}));
}

/// Before a stranger's address is proved, the server tells it nothing about keys.
TEST_F(GateTest, AnswersAboutKeysOnlyToProvedAddresses) {
  EXPECT_EQ(knock(Client(key_of("stranger", 50)), kStart), nullptr);
  EXPECT_TRUE(says_retry());
  EXPECT_EQ(gate.counters().unknown_key, 0u);
}

TEST_F(GateTest, RefusesAKeyThatItDoesNotHave) {
  const Client client = with_cookie(kStart, kFrom, key_of("stranger", 50));
  EXPECT_EQ(knock(client, kStart), nullptr);
  EXPECT_EQ(std::get<OpenRefusal>(said()),
            (OpenRefusal{.reason = RefusalReason::UnknownKey, .echo = client.handshake.echo()}));
  EXPECT_EQ(gate.counters().unknown_key, 1u);
}

TEST_F(GateTest, RefusesAHelloThatTheKeyDidNotMake) {
  const Bytes hello = with_cookie(kStart).hello();
  for (const std::size_t at : {std::size_t{47}, std::size_t{95}, std::size_t{126}}) {  // scene hash, proof
    Bytes forged = hello;
    forged[at] ^= std::byte{1};
    EXPECT_EQ(knock(forged, kStart), nullptr);
    EXPECT_EQ(std::get<OpenRefusal>(said()).reason, RefusalReason::UnknownKey);
  }
  EXPECT_EQ(gate.counters().unknown_key, 3u);
}

TEST_F(GateTest, TellsAClientOfAnotherVersionTheServersVersion) {
  Bytes later = Client().hello();
  later[4] ^= std::byte{1};  // another layout
  const auto foreign = std::get<ForeignHello>(*open_client_envelope(later));
  gate.refuse_version(foreign, answer);
  EXPECT_EQ(std::get<OpenRefusal>(said()), (OpenRefusal{.version = kProtocolVersion,
                                                        .reason = RefusalReason::VersionMismatch,
                                                        .echo = foreign.echo}));
  EXPECT_LE(answer.size(), later.size());
  EXPECT_EQ(gate.counters(), (GateCounters{.version_mismatch = 1}));
}

TEST_F(GateTest, LimitsHandshakesPerSecond) {
  const auto let_through = [&](Time now, int attempts) {
    int through = 0;
    for (int i = 0; i < attempts; ++i) through += gate.may_shake_hands(of_key, now) ? 1 : 0;
    return through;
  };
  EXPECT_EQ(let_through(kStart, 50), 10);
  EXPECT_EQ(gate.counters().too_many, 40u);
  EXPECT_EQ(let_through(kStart + std::chrono::milliseconds(50), 1), 0);
  EXPECT_EQ(let_through(kStart + std::chrono::milliseconds(501), 50), 5);
  EXPECT_EQ(let_through(kStart + std::chrono::hours(1), 50), 10);
  int through = 0;
  for (int ms = 0; ms < 10'000; ++ms)
    through += let_through(kStart + std::chrono::hours(2) + std::chrono::milliseconds(ms), 1);
  EXPECT_GE(through, 108);
  EXPECT_LE(through, 110);
}

TEST_F(GateTest, AClockThatStopsOrStepsBackGivesNoTokens) {
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(gate.may_shake_hands(of_key, kStart));
  EXPECT_FALSE(gate.may_shake_hands(of_key, kStart - std::chrono::seconds(5)));
  EXPECT_FALSE(gate.may_shake_hands(of_key, kStart));
  EXPECT_TRUE(gate.may_shake_hands(of_key, kStart + std::chrono::milliseconds(101)))
      << "and this costs nothing";
}

TEST_F(GateTest, AKeyThatHasUsedItsTokensTakesNoneOfTheOthers) {
  KeyHandshakes greedy = of_key;
  greedy.all = TokenBucket(3);
  int through = 0;
  for (int i = 0; i < 100; ++i) through += gate.may_shake_hands(greedy, kStart) ? 1 : 0;
  EXPECT_EQ(through, 3);
  for (int i = 0; i < 7; ++i) EXPECT_TRUE(gate.may_shake_hands(of_key, kStart));
  EXPECT_FALSE(gate.may_shake_hands(of_key, kStart));
}

TEST_F(GateTest, AKeyHasItsOwnHandshakesWhenAllSharedOnesAreTaken) {
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(gate.may_shake_hands(of_key, kStart));
  KeyHandshakes newcomer(20, 2);
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(gate.may_shake_hands(newcomer, kStart)) << i;
  EXPECT_FALSE(gate.may_shake_hands(newcomer, kStart));
  KeyHandshakes of_many(20, 4096);
  EXPECT_TRUE(gate.may_shake_hands(of_many, kStart)) << "one in any case";
  EXPECT_FALSE(gate.may_shake_hands(of_many, kStart));
}

}  // namespace
}  // namespace farshade
