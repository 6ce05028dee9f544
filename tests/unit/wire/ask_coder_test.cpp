#include "stereo/wire/ask_coder.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "tests/unit/wire/samples.h"

namespace farshade {
namespace {

using namespace wire_samples;

std::vector<BlockBits> noise_blocks(Extent size, std::mt19937& random) {
  std::vector<BlockBits> blocks(TileGrid{size}.count());
  for (BlockBits& tile : blocks) tile = static_cast<BlockBits>(random());
  return blocks;
}

/// The blocks along a circle.
std::vector<BlockBits> circle_blocks(Extent size) {
  const TileGrid grid{size};
  std::vector<BlockBits> blocks(grid.count());
  for (int i = 0; i < 10'000; ++i) {
    const double angle = i * 6.2831853 / 10'000, radius = 0.4 * std::min(size.width, size.height);
    const auto x = static_cast<std::uint32_t>(size.width / 2.0 + radius * std::cos(angle));
    const auto y = static_cast<std::uint32_t>(size.height / 2.0 + radius * std::sin(angle));
    blocks[y / 16 * grid.columns() + x / 16] |= block_bit(x % 16, y % 16);
  }
  return blocks;
}

struct Collected {
  std::vector<BlockBits> asked;
  KnownTiles known;

  explicit Collected(Extent size) : asked(TileGrid{size}.count()), known(asked.size()) {}

  Decoded<std::uint32_t> take(const Bytes& bytes) {
    const Decoded<ClientMessage> message = decode_client(bytes);
    if (!message) return refuse(message.error());
    return decode_ask_slice(std::get<AskSlice>(*message), asked, known);
  }
};

TEST(AskCoder, GivesTheBlocksBack) {
  std::mt19937 random(1);
  for (const Extent size : {Extent{1, 1}, Extent{16, 16}, Extent{17, 90}, Extent{700, 500}, Extent{8192, 3}})
    for (const auto& blocks :
         {std::vector<BlockBits>(TileGrid{size}.count(), kNoBlocks),
          std::vector<BlockBits>(TileGrid{size}.count(), kAllBlocks), noise_blocks(size, random)}) {
      Collected collected(size);
      std::uint32_t learned = 0;
      for (const Bytes& bytes : asked_messages(size, Side::Left, blocks)) {
        ASSERT_LE(bytes.size(), kMaxMessage_bytes);
        learned += collected.take(bytes).value();
        EXPECT_EQ(collected.take(bytes).value(), 0u);
      }
      EXPECT_EQ(learned, blocks.size());
      EXPECT_EQ(collected.asked, blocks);
    }
}

TEST(AskCoder, ACurveCostsAboutABitForEachOfItsBlocks) {
  const std::vector<BlockBits> blocks = circle_blocks({1024, 1024});
  double asked = 0;
  for (const BlockBits tile : blocks) asked += std::popcount(tile);
  const auto messages = asked_messages({1024, 1024}, Side::Right, blocks);
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_LT(8.0 * static_cast<double>(messages[0].size()), 2.5 * asked);
}

TEST(AskCoder, ALostSliceLeavesItsTilesUnknown) {
  std::mt19937 random(3);
  const Extent size{512, 512};
  const std::vector<BlockBits> blocks = noise_blocks(size, random);
  const auto messages = asked_messages(size, Side::Left, blocks);
  ASSERT_GT(messages.size(), 1u);
  Collected collected(size);
  for (std::size_t i = 1; i < messages.size(); ++i) ASSERT_TRUE(collected.take(messages[i]));
  const std::uint32_t gone = std::get<AskSlice>(*decode_client(messages[0])).tile_count;
  for (std::uint32_t tile = 0; tile < blocks.size(); ++tile) {
    EXPECT_EQ(collected.known[tile], tile < gone ? 0 : 1);
    EXPECT_EQ(collected.asked[tile], tile < gone ? kNoBlocks : blocks[tile]);
  }
}

TEST(AskCoder, NearlyEveryTruncationIsRefusedAndChangesNothing) {
  std::mt19937 random(4);
  const Extent size{200, 200};
  std::size_t accepted = 0, cuts = 0;
  for (const Bytes& whole : asked_messages(size, Side::Left, noise_blocks(size, random)))
    for (std::size_t length = 0; length < whole.size(); ++length, ++cuts) {
      Collected collected(size);
      if (collected.take(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length)))) {
        ++accepted;
        continue;
      }
      EXPECT_EQ(collected.asked, Collected(size).asked);
      EXPECT_EQ(collected.known, Collected(size).known);
    }
  EXPECT_LE(accepted, cuts / 50);
}

TEST(AskCoder, RefusesAnotherGridAndBytesAfterTheLastTile) {
  Bytes bytes = asked_messages({32, 32}, Side::Left, std::vector<BlockBits>(4, 0x0360)).at(0);
  EXPECT_EQ(Collected({48, 32}).take(bytes).error(), WireRefusal::OtherMask);
  bytes.push_back({});
  EXPECT_EQ(Collected({32, 32}).take(bytes).error(), WireRefusal::Block);
}

}  // namespace
}  // namespace farshade
