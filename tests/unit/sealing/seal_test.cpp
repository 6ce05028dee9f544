#include "stereo/sealing/seal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "stereo/messages/timing.h"
#include "tests/unit/messages/samples.h"

namespace farshade {
namespace {

using namespace wire_samples;

const Secret kKey(counting<32>(0));
constexpr SessionId kSession{0x0807060504030201};

Bytes seal(Sealer& sealer, const Bytes& message) {
  Bytes datagram;
  sealer.seal(message, datagram);
  return datagram;
}

Decoded<Bytes> open(Opener& opener, const Bytes& datagram) {
  const auto envelope = open_server_envelope(datagram);
  if (!envelope) return refuse(envelope.error());
  const auto* sealed = std::get_if<Sealed>(&*envelope);
  if (sealed == nullptr) return refuse(WireRefusal::Type);
  Bytes opened;
  return opener.open(*sealed, datagram, opened).map([](std::span<const std::byte> message) {
    return Bytes(message.begin(), message.end());
  });
}

std::vector<Bytes> messages(std::size_t count) {
  std::vector<Bytes> all;
  for (std::size_t i = 0; i < count; ++i) all.push_back(bytes_of({unsigned(i & 255), unsigned(i >> 8)}));
  return all;
}

class SealModes : public testing::TestWithParam<Sealing> {};
INSTANTIATE_TEST_SUITE_P(Both, SealModes, testing::Values(Sealing::On, Sealing::Off),
                         [](const auto& mode) { return mode.param == Sealing::On ? "On" : "Off"; });

TEST_P(SealModes, MessagesOfEveryLengthComeBack) {
  Sealer sealer(kSession, kKey, GetParam());
  Opener opener(kKey, GetParam());
  for (std::size_t size = 0; size <= kMaxMessage_bytes; size += size < 70 ? 1 : 97) {
    Bytes message(size);
    for (std::size_t i = 0; i < size; ++i) message[i] = static_cast<std::byte>(i * 7 + size);
    const Bytes datagram = seal(sealer, message);
    EXPECT_EQ(datagram.size(), size + kSealing_bytes);
    EXPECT_EQ(open(opener, datagram).value(), message);
  }
  EXPECT_EQ(seal(sealer, Bytes(kMaxMessage_bytes)).size(), kMaxDatagram_bytes);
}

TEST_P(SealModes, CountersCountFromNought) {
  Sealer sealer(kSession, kKey, GetParam());
  for (std::uint64_t i = 0; i < 1000; ++i) {
    Bytes datagram;
    EXPECT_EQ(sealer.seal(bytes_of({1}), datagram), i);
    const auto sealed = std::get<Sealed>(*open_server_envelope(datagram));
    EXPECT_EQ(sealed.counter, i);
    EXPECT_EQ(sealed.session, kSession);
  }
}

TEST_P(SealModes, RepeatedDatagramsAreRefused) {
  Sealer sealer(kSession, kKey, GetParam());
  Opener opener(kKey, GetParam());
  std::vector<Bytes> sent;
  for (const Bytes& message : messages(50)) sent.push_back(seal(sealer, message));
  for (const Bytes& datagram : sent) EXPECT_TRUE(open(opener, datagram));
  for (const Bytes& datagram : sent) EXPECT_EQ(open(opener, datagram).error(), WireRefusal::Replayed);
}

TEST_P(SealModes, AnyOrderWithinTheWindowOpens) {
  const std::uint32_t seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  Sealer sealer(kSession, kKey, GetParam());
  Opener opener(kKey, GetParam());
  const std::vector<Bytes> said = messages(4096);
  std::vector<Bytes> sent;
  for (const Bytes& message : said) sent.push_back(seal(sealer, message));
  std::vector<std::size_t> order(sent.size());
  std::iota(order.begin(), order.end(), 0u);
  std::shuffle(order.begin(), order.end(), random);
  for (const std::size_t i : order) ASSERT_EQ(open(opener, sent[i]).value(), said[i]);
}

TEST_P(SealModes, WhatHasLeftTheWindowIsRefused) {
  Sealer sealer(kSession, kKey, GetParam());
  Opener opener(kKey, GetParam());
  std::vector<Bytes> sent;
  for (const Bytes& message : messages(4098)) sent.push_back(seal(sealer, message));
  EXPECT_TRUE(open(opener, sent[4097]));
  EXPECT_TRUE(open(opener, sent[2]));
  EXPECT_EQ(open(opener, sent[1]).error(), WireRefusal::Replayed);
  EXPECT_EQ(open(opener, sent[0]).error(), WireRefusal::Replayed);
}

TEST(Secret, LeavesNothingBehind) {
  alignas(Secret) std::array<std::byte, sizeof(Secret)> room{};
  std::array<std::uint8_t, 32> bytes;
  bytes.fill(0xa5);
  auto* const secret = new (room.data()) Secret(bytes);
  ASSERT_EQ(std::ranges::count(room, std::byte{0xa5}), 32);
  secret->~Secret();
  EXPECT_EQ(std::ranges::count(room, std::byte{0xa5}), 0);
}

TEST(Seal, NoByteOfAMessageIsVisible) {
  Sealer sealer(kSession, kKey, Sealing::On);
  const Bytes message(300, std::byte{'a'});
  const Bytes once = seal(sealer, message), again = seal(sealer, message);
  EXPECT_LT(std::ranges::count(once, std::byte{'a'}), 30);
  EXPECT_FALSE(
      std::equal(once.begin() + kSealedHeader_bytes, once.end(), again.begin() + kSealedHeader_bytes));
}

TEST(Seal, EveryFlippedBitIsRefusedAndChangesNothing) {
  Sealer sealer(kSession, kKey, Sealing::On);
  Opener opener(kKey, Sealing::On);
  EXPECT_TRUE(open(opener, seal(sealer, bytes_of({1}))));
  const Bytes whole = seal(sealer, bytes_of({1, 2, 3, 4, 5, 6, 7}));
  for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
    Bytes flipped = whole;
    flipped[bit / 8] ^= std::byte{1} << bit % 8;
    EXPECT_FALSE(open(opener, flipped)) << "bit " << bit;
    ASSERT_EQ(opener.window().newest(), 0u) << "bit " << bit;
  }
  EXPECT_TRUE(open(opener, whole));
}

TEST(Seal, EveryTruncationIsRefusedAndChangesNothing) {
  Sealer sealer(kSession, kKey, Sealing::On);
  Opener opener(kKey, Sealing::On);
  const Bytes whole = seal(sealer, bytes_of({1, 2, 3, 4, 5, 6, 7}));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_EQ(open(opener, cut).error(), size < kSealing_bytes ? WireRefusal::Truncated : WireRefusal::Forged)
        << size;
    ASSERT_EQ(opener.window().newest(), std::nullopt);
  }
  Bytes longer = whole;
  longer.push_back(std::byte{0});
  EXPECT_EQ(open(opener, longer).error(), WireRefusal::Forged);
  EXPECT_TRUE(open(opener, whole));
}

TEST(Seal, AForgedCounterMovesNoWindow) {
  Sealer sealer(kSession, kKey, Sealing::On);
  Opener opener(kKey, Sealing::On);
  const Bytes first = seal(sealer, bytes_of({1}));
  Bytes far = first;
  far[15 + 3] = std::byte{4};  // counter 4 << 24
  EXPECT_EQ(open(opener, far).error(), WireRefusal::Forged);
  EXPECT_EQ(opener.window().newest(), std::nullopt);
  EXPECT_TRUE(open(opener, first));
}

TEST(Seal, ACounterThatNoSenderReachesIsRefusedAlthoughItOpens) {
  Sealer sealer(kSession, kKey, Sealing::Off);
  Opener opener(kKey, Sealing::Off);
  const Bytes first = seal(sealer, bytes_of({1}));
  Bytes far = first;
  far[15 + 5] = std::byte{0x81};  // more than 2^47; without sealing every counter opens
  EXPECT_EQ(open(opener, far).error(), WireRefusal::CounterJump);
  EXPECT_EQ(opener.window().newest(), std::nullopt);
  EXPECT_TRUE(open(opener, first));
}

constexpr std::uint64_t kFew = 3;  // datagrams of an epoch

/// Made by `python3` and hashlib.blake2b, not by the code under test.
TEST(Seal, TheNextKeyIsAHashOfTheLast) {
  const Secret next(std::array<std::uint8_t, 32>{
      0x01, 0x94, 0x29, 0x5d, 0x28, 0x32, 0x8d, 0xb6, 0x62, 0xaf, 0x62, 0x0d, 0xb0, 0xa2, 0x3b, 0x54,
      0xbc, 0xff, 0x9a, 0x86, 0x85, 0x44, 0xe0, 0xad, 0xd8, 0x0b, 0xab, 0x47, 0xc0, 0x92, 0xff, 0x75});
  EXPECT_EQ(next_key(kKey), next);
}

TEST(Seal, AnEpochEndsWithItsDatagramsAndWithItsTime) {
  Sealer sealer(kSession, kKey, Sealing::On, kProtocolVersion, kFew);
  std::vector<std::uint16_t> epochs;
  for (int i = 0; i < 8; ++i) {
    seal(sealer, bytes_of({1}));
    epochs.push_back(sealer.epoch());
  }
  EXPECT_EQ(epochs, (std::vector<std::uint16_t>{0, 0, 0, 1, 1, 1, 2, 2}));
  sealer.renew(Time(std::chrono::seconds(7)));
  sealer.renew(Time(std::chrono::seconds(7) + kEpochTime));
  EXPECT_EQ(sealer.epoch(), 2u);
  sealer.renew(Time(std::chrono::seconds(7) + kEpochTime + Duration(1)));
  EXPECT_EQ(sealer.epoch(), 3u);
  EXPECT_EQ(Sealer(kSession, kKey, Sealing::On).epoch(), 0u);
}

TEST(Seal, AReceiverFollowsTheEpochsAlsoIfDatagramsAreMissing) {
  Sealer sealer(kSession, kKey, Sealing::On, kProtocolVersion, kFew);
  Opener opener(kKey, Sealing::On);
  for (unsigned i = 0; i < 60; ++i) {
    const Bytes datagram = seal(sealer, bytes_of({i}));
    if (i % 20 != 0) continue;  // 6 or 7 epochs between two
    EXPECT_EQ(open(opener, datagram), bytes_of({i})) << i;
  }
}

TEST(Seal, TheKeyOfAnEpochDoesNotOpenEarlierOnes) {
  Sealer sealer(kSession, kKey, Sealing::On, kProtocolVersion, kFew);
  const Bytes first = seal(sealer, bytes_of({1}));
  for (unsigned i = 0; i < kFew; ++i) seal(sealer, bytes_of({2}));
  const Secret stolen = next_key(kKey);
  Opener thief(stolen, Sealing::On);
  EXPECT_EQ(open(thief, first).error(), WireRefusal::Forged);
}

TEST(Seal, TheLastKeyIsKeptForAGraceAndThenForgotten) {
  constexpr std::uint64_t kLong = 2 * kEpochGrace;
  Sealer sealer(kSession, kKey, Sealing::On, kProtocolVersion, kLong);
  Opener opener(kKey, Sealing::On);
  std::vector<Bytes> datagrams;
  for (std::uint64_t i = 0; i < 2 * kLong; ++i) datagrams.push_back(seal(sealer, bytes_of({1})));
  EXPECT_TRUE(open(opener, datagrams[0]));
  EXPECT_TRUE(open(opener, datagrams[kLong]));
  EXPECT_TRUE(open(opener, datagrams[kLong + kEpochGrace]));
  EXPECT_TRUE(open(opener, datagrams[kLong - 1])) << "within the grace";
  EXPECT_TRUE(open(opener, datagrams[kLong + kEpochGrace + 1]));
  EXPECT_EQ(open(opener, datagrams[kLong - 2]).error(), WireRefusal::Replayed) << "its key is forgotten";
  EXPECT_TRUE(open(opener, datagrams[kLong + 1])) << "late, but of this epoch";
}

TEST(Seal, AnEpochBeforeTheLastIsForgottenAtOnce) {
  Sealer sealer(kSession, kKey, Sealing::On, kProtocolVersion, kFew);
  Opener opener(kKey, Sealing::On);
  const Bytes old = seal(sealer, bytes_of({1}));
  for (unsigned i = 1; i < 2 * kFew; ++i) seal(sealer, bytes_of({2}));
  EXPECT_TRUE(open(opener, seal(sealer, bytes_of({3}))));  // epoch 2
  EXPECT_EQ(open(opener, old).error(), WireRefusal::Replayed);
}

TEST(Seal, AForgedEpochMovesNothing) {
  Sealer sealer(kSession, kKey, Sealing::On);
  Opener opener(kKey, Sealing::On);
  const Bytes first = seal(sealer, bytes_of({1})), second = seal(sealer, bytes_of({2}));
  Bytes forged = first;
  forged[21] = std::byte{kMostEpochStep};
  EXPECT_EQ(open(opener, forged).error(), WireRefusal::Forged);
  forged[21] = std::byte{kMostEpochStep + 1};
  EXPECT_EQ(open(opener, forged).error(), WireRefusal::CounterJump);
  EXPECT_TRUE(open(opener, first));
  EXPECT_TRUE(open(opener, second));
}

TEST(Seal, AnotherKeyDoesNotOpen) {
  Sealer sealer(kSession, kKey, Sealing::On);
  const Bytes datagram = seal(sealer, bytes_of({1}));
  for (std::size_t bit = 0; bit < 256; ++bit) {
    auto bytes = counting<32>(0);
    bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1u << bit % 8));
    Opener other(Secret(bytes), Sealing::On);
    EXPECT_EQ(open(other, datagram).error(), WireRefusal::Forged) << bit;
  }
}

TEST(Seal, AnotherSessionDoesNotOpenUnderTheSameKey) {
  Sealer here(kSession, kKey, Sealing::On), there(SessionId{9}, kKey, Sealing::On);
  Opener opener(kKey, Sealing::On);
  const Bytes ours = seal(here, bytes_of({1}));
  Bytes theirs = seal(there, bytes_of({1}));
  std::copy_n(ours.begin(), kSealedHeader_bytes, theirs.begin());
  EXPECT_EQ(open(opener, theirs).error(), WireRefusal::Forged);
}

TEST(Seal, WhatIsNotSealedDoesNotOpenWhereSealingIsOn) {
  Sealer sealer(kSession, kKey, Sealing::Off);
  Opener opener(kKey, Sealing::On);
  EXPECT_EQ(open(opener, seal(sealer, bytes_of({1}))).error(), WireRefusal::Forged);
}

TEST(Seal, OffLeavesTheMessageAndATagOfZeros) {
  Sealer sealer(kSession, kKey, Sealing::Off);
  const Bytes message = bytes_of({1, 2, 3});
  const Bytes datagram = seal(sealer, message);
  Bytes expected = message;
  expected.resize(message.size() + kTag_bytes);
  EXPECT_EQ(Bytes(datagram.begin() + kSealedHeader_bytes, datagram.end()), expected);
  for (std::size_t i = datagram.size() - kTag_bytes; i < datagram.size(); ++i) {
    Bytes changed = datagram;
    changed[i] = std::byte{1};
    Opener opener(kKey, Sealing::Off);
    EXPECT_EQ(open(opener, changed).error(), WireRefusal::Forged);
  }
}

TEST(SealAlone, OpensWholeAndWithItsKeyOnly) {
  const Bytes message = bytes_of({1, 2, 3});
  const Bytes sealed = seal_alone(kKey, Sealing::On, message);
  EXPECT_EQ(sealed.size(), message.size() + kTag_bytes);
  Bytes opened;
  EXPECT_TRUE(open_alone(kKey, Sealing::On, sealed, opened));
  EXPECT_EQ(opened, message);
  EXPECT_FALSE(open_alone(Secret(counting<32>(1)), Sealing::On, sealed, opened));
  EXPECT_FALSE(open_alone(kKey, Sealing::On, std::span(sealed).first(15), opened));
}

TEST(SealDeathTest, StopsAtAMessageThatDoesNotFit) {
  Sealer sealer(kSession, kKey, Sealing::On);
  Bytes datagram;
  EXPECT_DEATH(sealer.seal(Bytes(kMaxMessage_bytes + 1), datagram), "fits into a sealed datagram");
}

}  // namespace
}  // namespace farshade
