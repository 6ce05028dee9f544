#include "stereo/codec/range_coder.h"

#include <gtest/gtest.h>

#include "tests/unit/messages/samples.h"

namespace farshade {
namespace {

using namespace wire_samples;

constexpr std::size_t kModels = 7;
using Models = std::array<BitModel, kModels>;

struct Decision {
  std::size_t model = 0;
  bool value = false;
};

/// Each model mostly has one value; the last has any.
std::vector<Decision> decisions_of(std::size_t count, std::mt19937& random) {
  std::vector<Decision> decisions(count);
  for (Decision& decision : decisions) {
    decision.model = random() % kModels;
    decision.value = random() % 64 < (std::uint32_t{1} << decision.model) / 2;
  }
  return decisions;
}

Bytes coded(const std::vector<Decision>& decisions) {
  Bytes bytes;
  RangeEncoder encoder(bytes);
  Models models;
  for (const Decision& decision : decisions) encoder.bit(models[decision.model], decision.value);
  encoder.finish();
  return bytes;
}

/// Whether `bytes` are the message of just these decisions.
bool reads(const Bytes& bytes, const std::vector<Decision>& decisions) {
  RangeDecoder decoder(bytes);
  Models models;
  for (const Decision& decision : decisions) {
    bool value = false;
    decoder.bit(models[decision.model], value);
    if (value != decision.value) return false;
  }
  return decoder.is_at_end();
}

TEST(RangeCoder, GivesTheDecisionsBack) {
  const std::uint32_t seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  for (const std::size_t count : {0u, 1u, 2u, 10u, 100u, 1'000u, 100'000u}) {
    const std::vector<Decision> decisions = decisions_of(count, random);
    EXPECT_TRUE(reads(coded(decisions), decisions)) << count << " decisions";
  }
}

TEST(RangeCoder, GivesPlainBitsBack) {
  Bytes bytes;
  RangeEncoder encoder(bytes);
  for (std::uint32_t i = 0; i < 1000; ++i) encoder.plain(static_cast<std::uint16_t>(i * 40503));
  encoder.finish();
  EXPECT_EQ(bytes.size(), 2001u);
  RangeDecoder decoder(bytes);
  for (std::uint32_t i = 0; i < 1000; ++i) {
    std::uint16_t word = 0;
    decoder.plain(word);
    EXPECT_EQ(word, static_cast<std::uint16_t>(i * 40503));
  }
  EXPECT_TRUE(decoder.is_at_end());
}

TEST(RangeCoder, PropagatesCarries) {
  // Ones of an unlikely model move to the upper end of the interval; then bytes of 255 get carries.
  std::mt19937 random(3);
  for (int round = 0; round < 2'000; ++round) {
    std::vector<Decision> decisions(random() % 60);
    for (Decision& decision : decisions) decision = {random() % 2, random() % 8 != 0};
    ASSERT_TRUE(reads(coded(decisions), decisions)) << "round " << round;
  }
}

TEST(RangeCoder, RewindingForgetsLaterDecisions) {
  std::mt19937 random(4);
  for (int round = 0; round < 2'000; ++round) {
    const std::vector<Decision> kept = decisions_of(random() % 200, random);
    Bytes bytes;
    RangeEncoder encoder(bytes);
    Models models;
    for (const Decision& decision : kept) encoder.bit(models[decision.model], decision.value);
    const RangeEncoder::Mark mark = encoder.mark();
    for (std::size_t i = random() % 200; i > 0; --i) encoder.bit(models[random() % 2], random() % 8 != 0);
    encoder.rewind(mark);
    encoder.finish();
    ASSERT_EQ(bytes, coded(kept)) << "round " << round;
  }
}

TEST(RangeCoder, RefusesEveryTruncationAndEveryByteMore) {
  std::mt19937 random(5);
  const std::vector<Decision> decisions = decisions_of(3'000, random);
  const Bytes whole = coded(decisions);
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_FALSE(reads(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)), decisions));
  Bytes longer = whole;
  longer.push_back({});
  EXPECT_FALSE(reads(longer, decisions));
}

TEST(RangeCoder, SaysThatTheBytesHaveEnded) {
  const Bytes bytes = bytes_of({0x80, 1, 2});
  RangeDecoder decoder(bytes);
  EXPECT_FALSE(decoder.has_failed());
  std::uint16_t word = 0;
  for (int i = 0; i < 100; ++i) decoder.plain(word);
  EXPECT_TRUE(decoder.has_failed());
  EXPECT_FALSE(decoder.is_at_end());
}

TEST(RangeCoder, CostsAsMuchAsTheDecisionsTell) {
  // 100,000 decisions of which 1 in 32 is a one have 0.2006 bits each.
  std::mt19937 random(6);
  Bytes bytes;
  RangeEncoder encoder(bytes);
  BitModel model;
  for (int i = 0; i < 100'000; ++i) encoder.bit(model, random() % 32 == 0);
  encoder.finish();
  EXPECT_LT(static_cast<double>(bytes.size()), 1.2 * 100'000 * 0.2006 / 8);
}

TEST(BitModel, StaysBetweenItsLimits) {
  for (const bool value : {false, true})
    for (const unsigned initial : {0u, 128u, 255u}) {
      BitModel model(static_cast<std::uint8_t>(initial));
      for (int i = 0; i < 1'000; ++i) {
        model.learn(value);
        EXPECT_GE(model.zero(), 8u);
        EXPECT_LE(model.zero(), 4088u);
      }
    }
}

TEST(BitModel, MovesASixteenthOfTheWay) {
  BitModel model(128);
  EXPECT_EQ(model.zero(), 2056u);
  model.learn(true);
  EXPECT_EQ(model.zero(), 2056u - 128u);
  model.learn(false);
  EXPECT_EQ(model.zero(), 1928u + 135u);
}

}  // namespace
}  // namespace farshade
