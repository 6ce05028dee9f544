#include "stereo/sealing/handshake.h"

#include <gtest/gtest.h>
#include <sodium.h>

#include <set>
#include <string_view>

#include "tests/support/watched_sodium.h"
#include "tests/unit/messages/samples.h"

namespace farshade {
namespace {

using namespace wire_samples;

const SharedKey kStrangersKey{.name = "desk", .secret = counting<32>(1)};

Bytes hello_of(const ClientHandshake& client) {
  Bytes datagram;
  client.write_hello(datagram);
  return datagram;
}
Hello read_hello(const Bytes& datagram) {
  return std::get<Hello>(*open_client_envelope(datagram));
}
Accepted accepted(const Bytes& hello_datagram, const SharedKey& key, const ServerMessage& answer) {
  return *accept(read_hello(hello_datagram), hello_datagram, key, answer);
}
std::optional<ClientHandshake::Completed> take(const ClientHandshake& client, const Bytes& datagram) {
  const auto envelope = open_server_envelope(datagram);
  if (!envelope || !std::holds_alternative<Accept>(*envelope)) return std::nullopt;
  return client.take(std::get<Accept>(*envelope), datagram);
}

/// A handshake with shared_key() that the server has answered.
struct Answered {
  ClientHandshake client{shared_key(), counting_hash()};
  Bytes hello = hello_of(client);
  Accepted server = accepted(hello, shared_key(), welcome());
};

TEST(Handshake, GivesBothSidesTheSameKeys) {
  const Answered h;
  const auto completed = take(h.client, h.server.datagram);
  ASSERT_TRUE(completed);
  EXPECT_EQ(std::get<Welcome>(completed->answer), welcome());
  EXPECT_EQ(completed->keys.session, h.server.keys.session);
  EXPECT_EQ(completed->keys.to_server, h.server.keys.to_server);
  EXPECT_EQ(completed->keys.to_client, h.server.keys.to_client);
  EXPECT_EQ(completed->keys.sealing, Sealing::On);
  EXPECT_EQ(h.server.keys.sealing, Sealing::On);
  EXPECT_NE(completed->keys.to_server, completed->keys.to_client);
}

TEST(Handshake, SessionsOpenWhatTheOtherSideSealsAndNotWhatTheySealThemselves) {
  const Answered h;
  const SessionKeys client = take(h.client, h.server.datagram)->keys, server = h.server.keys;
  Sealer up(client.session, client.to_server, client.sealing);
  Opener at_server(server.to_server, server.sealing), at_client(client.to_client, client.sealing);
  Bytes datagram, opened;
  up.seal(bytes_of({1}), datagram);
  const Sealed sealed = std::get<Sealed>(*open_client_envelope(datagram));
  EXPECT_EQ(at_client.open(sealed, datagram, opened).error(), WireRefusal::Forged);
  EXPECT_TRUE(at_server.open(sealed, datagram, opened));
}

TEST(Handshake, CarriesARefusalToAClientWithTheKey) {
  const ClientHandshake client(shared_key(), counting_hash());
  const auto completed = take(client, accepted(hello_of(client), shared_key(), refusal()).datagram);
  ASSERT_TRUE(completed);
  EXPECT_EQ(std::get<Refusal>(completed->answer), refusal());
}

TEST(Handshake, TakesWelcomeOrRefusalAndNoOtherAnswer) {
  const ClientHandshake client(shared_key(), counting_hash());
  EXPECT_FALSE(take(client, accepted(hello_of(client), shared_key(), probe()).datagram));
}

TEST(Handshake, AnswerIsNoLongerThanTheHello) {
  const Answered h;
  EXPECT_LE(h.server.datagram.size(), h.hello.size());
}

TEST(Handshake, HelloIsProvedByItsKeyAlone) {
  const Answered h;
  EXPECT_TRUE(is_proved(read_hello(h.hello), h.hello, shared_key()));
  EXPECT_FALSE(is_proved(read_hello(h.hello), h.hello, kStrangersKey));
}

TEST(Handshake, AProofIsComparedInATimeThatDoesNotTellWhereItDiffers) {
  if (!WatchedSodium::is_possible()) GTEST_SKIP() << "libsodium is a static library";
  const Answered h;
  const Hello hello = read_hello(h.hello);
  const WatchedSodium watched;
  EXPECT_TRUE(is_proved(hello, h.hello, shared_key()));
  EXPECT_FALSE(is_proved(hello, h.hello, kStrangersKey));
  EXPECT_EQ(watched.compared, std::vector(2, sizeof hello.proof));
}

TEST(Handshake, AHashLeavesNoStateBehind) {
  if (!WatchedSodium::is_possible()) GTEST_SKIP() << "libsodium is a static library";
  const Answered h;
  const Hello hello = read_hello(h.hello);
  const WatchedSodium watched;
  EXPECT_TRUE(is_proved(hello, h.hello, shared_key()));
  EXPECT_EQ(std::ranges::count(watched.wiped, sizeof(crypto_generichash_state)), 1);
}

/// Any changed bit of public key, key name, scene hash, cookie or proof is detected.
TEST(Handshake, EveryFlippedBitOfAHelloUndoesItsProof) {
  const Answered h;
  for (std::size_t bit = 0; bit < 8 * h.hello.size(); ++bit) {
    Bytes flipped = h.hello;
    flipped[bit / 8] ^= std::byte{1} << bit % 8;
    const auto envelope = open_client_envelope(flipped);
    if (!envelope || !std::holds_alternative<Hello>(*envelope)) continue;
    EXPECT_FALSE(is_proved(std::get<Hello>(*envelope), flipped, shared_key())) << "bit " << bit;
  }
}

TEST(Handshake, EveryFlippedBitOfAnAcceptIsRefused) {
  const Answered h;
  for (std::size_t bit = 0; bit < 8 * h.server.datagram.size(); ++bit) {
    Bytes flipped = h.server.datagram;
    flipped[bit / 8] ^= std::byte{1} << bit % 8;
    EXPECT_FALSE(take(h.client, flipped)) << "bit " << bit;
  }
  EXPECT_TRUE(take(h.client, h.server.datagram));
}

TEST(Handshake, EveryTruncatedAcceptIsRefused) {
  const Answered h;
  for (std::size_t size = 0; size < h.server.datagram.size(); ++size) {
    const Bytes cut(h.server.datagram.begin(),
                    h.server.datagram.begin() + static_cast<std::ptrdiff_t>(size));  // its own allocation
    EXPECT_FALSE(take(h.client, cut)) << size;
  }
}

TEST(Handshake, AServerWithoutTheKeyIsNotBelieved) {
  const ClientHandshake client(shared_key(), counting_hash());
  EXPECT_FALSE(take(client, accepted(hello_of(client), kStrangersKey, welcome()).datagram));
}

/// The keys depend on the whole handshake: a server that received another scene hash has other keys.
TEST(Handshake, AHelloThatWasChangedOnItsWayGivesOtherKeys) {
  const ClientHandshake client(shared_key(), counting_hash());
  for (const std::size_t at : {std::size_t{7 + 31}, std::size_t{39}, std::size_t{47}, std::size_t{78}}) {
    Bytes changed = hello_of(client);
    changed[at] ^= std::byte{1};
    EXPECT_FALSE(take(client, accepted(changed, shared_key(), welcome()).datagram)) << at;
  }
}

TEST(Handshake, AnotherServersPublicKeyIsRefused) {
  const Answered h;
  Bytes changed = h.server.datagram;
  const Bytes other = accepted(h.hello, shared_key(), welcome()).datagram;
  std::copy_n(other.begin() + 31, 32, changed.begin() + 31);
  EXPECT_FALSE(take(h.client, changed));
}

/// Points of small order give a shared secret that everyone knows.
TEST(Handshake, PublicKeysThatGiveNoSecretAreRefused) {
  ClientHandshake client(shared_key(), counting_hash());
  Hello hello = read_hello(hello_of(client));
  for (const std::uint8_t first : {std::uint8_t{0}, std::uint8_t{1}}) {
    hello.client = {first};
    const Bytes datagram = enveloped(hello);
    EXPECT_FALSE(accept(hello, datagram, shared_key(), welcome()));

    const Answered h;
    Bytes changed = h.server.datagram;
    std::fill_n(changed.begin() + 31, 32, std::byte{0});
    changed[31] = std::byte{first};
    EXPECT_FALSE(take(h.client, changed));
  }
}

TEST(Handshake, AnAnswerToAnotherHelloIsRefused) {
  const Answered mine, other;
  EXPECT_FALSE(take(mine.client, other.server.datagram));
  Bytes echoed = other.server.datagram;
  std::copy_n(mine.server.datagram.begin() + 7, 16, echoed.begin() + 7);
  EXPECT_FALSE(take(mine.client, echoed));
}

TEST(Handshake, SendsACookieOnceItHasOne) {
  ClientHandshake client(shared_key(), counting_hash());
  EXPECT_EQ(read_hello(hello_of(client)).cookie, Cookie{});
  EXPECT_FALSE(client.take(Retry{.echo = counting<16>(0), .cookie = counting<16>(1)}));
  EXPECT_EQ(read_hello(hello_of(client)).cookie, Cookie{});
  const PublicKey before = read_hello(hello_of(client)).client;
  EXPECT_TRUE(client.take(Retry{.echo = client.echo(), .cookie = counting<16>(1)}));
  const Bytes second = hello_of(client);
  EXPECT_EQ(read_hello(second).cookie, counting<16>(1));
  EXPECT_EQ(read_hello(second).client, before);
  EXPECT_TRUE(is_proved(read_hello(second), second, shared_key()));
}

/// A cookie that expires while the accept is in transit, or a forged retry, has no effect.
TEST(Handshake, AnAcceptOfAnEarlierCookieStillOpens) {
  ClientHandshake client(shared_key(), counting_hash());
  ASSERT_TRUE(client.take(Retry{.echo = client.echo(), .cookie = counting<16>(1)}));
  const Accepted first = accepted(hello_of(client), shared_key(), welcome());
  ASSERT_TRUE(client.take(Retry{.echo = client.echo(), .cookie = counting<16>(2)}));
  EXPECT_TRUE(take(client, first.datagram));
}

TEST(Handshake, NoTwoHandshakesShareAKey) {
  std::set<std::array<std::uint8_t, 32>> keys;
  std::set<SessionId> sessions;
  const auto bytes_of_secret = [](const Secret& secret) {
    std::array<std::uint8_t, 32> bytes;
    std::copy_n(secret.data(), 32, bytes.begin());
    return bytes;
  };
  for (int i = 0; i < 100; ++i) {
    const Answered h;
    keys.insert(bytes_of_secret(h.server.keys.to_server));
    keys.insert(bytes_of_secret(h.server.keys.to_client));
    sessions.insert(h.server.keys.session);
  }
  EXPECT_EQ(keys.size(), 200u);
  EXPECT_EQ(sessions.size(), 100u);
}

/// Forward secrecy: the shared key, the hello and all datagrams together do not determine the session keys.
TEST(Handshake, KeysDependOnSecretsThatAreNeverSent) {
  const Answered h;
  const Accepted again = accepted(h.hello, shared_key(), welcome());
  EXPECT_NE(h.server.keys.to_server, again.keys.to_server);
  EXPECT_NE(h.server.keys.to_client, again.keys.to_client);
  EXPECT_NE(std::get<Accept>(*open_server_envelope(h.server.datagram)).server,
            std::get<Accept>(*open_server_envelope(again.datagram)).server);
}

/// The same hello, repeated by the network or a thief, reaches a server that remembers nothing. All its
/// counters begin at 0 again, but its keys are new.
TEST(Handshake, AServerThatRestartsNeverReusesANonceUnderAKey) {
  const ClientHandshake client(shared_key(), counting_hash());
  const Bytes hello = hello_of(client);
  const Accepted before = accepted(hello, shared_key(), welcome());
  const Accepted after = accepted(hello, shared_key(), welcome());
  EXPECT_NE(before.keys.session, after.keys.session);
  EXPECT_NE(before.keys.to_client, after.keys.to_client);
  EXPECT_NE(before.keys.to_server, after.keys.to_server);

  const Bytes message(200, std::byte{0x5a});
  const auto first_of = [&](const SessionKeys& keys) {
    Sealer sealer(keys.session, keys.to_client, keys.sealing);
    Bytes datagram;
    EXPECT_EQ(sealer.seal(message, datagram), 0u);
    return datagram;
  };
  const Bytes a = first_of(before.keys), b = first_of(after.keys);
  std::size_t same = 0;  // equal bytes of the two key streams; the expected share is 1 in 256
  for (std::size_t i = kSealedHeader_bytes; i < a.size() - kTag_bytes; ++i) same += a[i] == b[i] ? 1 : 0;
  EXPECT_LT(same, 20u);
  const SessionKeys completed = take(client, after.datagram)->keys;
  Opener opener(completed.to_client, completed.sealing);
  Bytes opened;
  EXPECT_EQ(opener.open(std::get<Sealed>(*open_server_envelope(a)), a, opened).error(), WireRefusal::Forged);
  EXPECT_TRUE(opener.open(std::get<Sealed>(*open_server_envelope(b)), b, opened));
}

/// In unsealed datagrams, only the echo distinguishes the handshakes.
TEST(Handshake, OfTheKeyThatEveryoneKnowsTakesItsOwnAnswerOnly) {
  const ClientHandshake mine(insecure_key(), counting_hash()), other(insecure_key(), counting_hash());
  EXPECT_FALSE(take(mine, accepted(hello_of(other), insecure_key(), welcome()).datagram));
}

TEST(Handshake, OfTheKeyThatEveryoneKnowsSealsNothing) {
  const ClientHandshake client(insecure_key(), counting_hash());
  const Accepted server = accepted(hello_of(client), insecure_key(), welcome());
  const auto completed = take(client, server.datagram);
  ASSERT_TRUE(completed);
  EXPECT_EQ(completed->keys.sealing, Sealing::Off);
  EXPECT_EQ(server.keys.sealing, Sealing::Off);
  EXPECT_EQ(insecure_key().secret, (std::array<std::uint8_t, 32>{}));
}

// The key schedule again, computed step by step as PROTOCOL.md describes it.

using Digest = std::array<std::uint8_t, 32>;

Digest blake2b(std::span<const std::uint8_t> key, const std::vector<std::uint8_t>& data) {
  Digest digest;
  crypto_generichash(digest.data(), digest.size(), data.data(), data.size(), key.data(), key.size());
  return digest;
}

void append(std::vector<std::uint8_t>& data, std::span<const std::byte> bytes) {
  for (const std::byte byte : bytes) data.push_back(std::to_integer<std::uint8_t>(byte));
}

TEST(Handshake, KeysAreDerivedAsThePageSays) {
  ASSERT_GE(sodium_init(), 0);
  Hello hello{.client = {}, .key = id_of(shared_key()), .scene_hash = counting_hash(), .cookie = {}};
  std::array<std::uint8_t, 32> secret;
  crypto_kx_keypair(hello.client.data(), secret.data());
  const auto labelled = [](std::string_view label) {
    return std::vector<std::uint8_t>(label.begin(), label.end());
  };

  auto said = labelled("farshade-2 hello");
  const Bytes unproved = enveloped(hello);
  append(said, std::span(unproved).first(95));
  hello.proof = blake2b(shared_key().secret, said);
  const Bytes hello_bytes = enveloped(hello);
  EXPECT_TRUE(is_proved(hello, hello_bytes, shared_key()));
  const Accepted server = accepted(hello_bytes, shared_key(), welcome());
  const auto answer = std::get<Accept>(*open_server_envelope(server.datagram));

  std::array<std::uint8_t, 32> down, up;
  ASSERT_EQ(crypto_kx_client_session_keys(down.data(), up.data(), hello.client.data(), secret.data(),
                                          answer.server.data()),
            0);
  std::vector<std::uint8_t> transcript;
  append(transcript, std::span(hello_bytes).first(79));
  append(transcript, std::span(server.datagram).first(63));
  const Digest open_words = blake2b({}, transcript);
  const auto derived = [&](std::string_view label) {
    auto data = labelled(label);
    for (const auto& part : {up, down, open_words}) data.insert(data.end(), part.begin(), part.end());
    return Secret(blake2b(shared_key().secret, data));
  };
  EXPECT_EQ(server.keys.to_server, derived("farshade-2 to server"));
  EXPECT_EQ(server.keys.to_client, derived("farshade-2 to client"));
  Bytes message;
  ASSERT_TRUE(open_alone(derived("farshade-2 accept"), Sealing::On, answer.sealed, message));
  EXPECT_EQ(message, encoded(ServerMessage(welcome())));
}

}  // namespace
}  // namespace farshade
