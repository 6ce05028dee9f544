#include "stereo/codec/ask_coder.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "tests/unit/messages/samples.h"

namespace farshade {
namespace {

using namespace wire_samples;

/// The blocks along a circle, in the light of share `share`.
std::vector<RequestedTile> circle_blocks(Extent size, std::uint32_t share) {
  const TileGrid grid{size};
  std::vector<RequestedTile> requested(grid.count());
  for (int i = 0; i < 10'000; ++i) {
    const double angle = i * 6.2831853 / 10'000, radius = 0.4 * std::min(size.width, size.height);
    const auto x = static_cast<std::uint32_t>(size.width / 2.0 + radius * std::cos(angle));
    const auto y = static_cast<std::uint32_t>(size.height / 2.0 + radius * std::sin(angle));
    requested[y / 16 * grid.columns() + x / 16].shares[share] |= block_bit(x % 16, y % 16);
  }
  return requested;
}

struct Collected {
  std::vector<RequestedTile> requested;
  ReceivedTiles known;

  explicit Collected(Extent size) : requested(TileGrid{size}.count()), known(requested.size()) {}

  Decoded<std::uint32_t> take(const Bytes& bytes) {
    const Decoded<ClientMessage> message = decode_client(bytes);
    if (!message) return refuse(message.error());
    return decode_ask_slice(std::get<AskSlice>(*message), requested, known);
  }
};

class AskRoundTrip : public testing::TestWithParam<std::uint32_t> {};

TEST_P(AskRoundTrip, GivesTheBlocksBack) {
  const std::uint32_t seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  for (const Extent size :
       {Extent{1, 1}, Extent{16, 16}, Extent{17, 90}, Extent{700, 500}, Extent{8192, 3}}) {
    const std::size_t tiles = TileGrid{size}.count();
    for (const auto& requested :
         {std::vector<RequestedTile>(tiles), noise_requested(size, GetParam(), random),
          std::vector<RequestedTile>(tiles, all_lights_in(kAllBlocks, GetParam()))}) {
      Collected collected(size);
      std::uint32_t learned = 0;
      for (const Bytes& bytes : requested_messages(size, Side::Left, GetParam(), requested)) {
        ASSERT_LE(bytes.size(), kMaxMessage_bytes);
        learned += collected.take(bytes).value();
        EXPECT_EQ(collected.take(bytes).value(), 0u);
      }
      EXPECT_EQ(learned, tiles);
      EXPECT_EQ(collected.requested, requested);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Lights, AskRoundTrip, testing::Values(0u, 1u, 2u, 3u, 7u, 8u, 9u, 40u, 256u));

double blocks_of(const std::vector<RequestedTile>& requested) {
  double blocks = 0;
  for (const RequestedTile& tile : requested) blocks += std::popcount(tile.any());
  return blocks;
}

TEST(AskCoder, ACurveCostsAboutABitForEachOfItsBlocks) {
  const std::vector<RequestedTile> requested = circle_blocks({1024, 1024}, 0);
  const auto messages = requested_messages({1024, 1024}, Side::Right, 1, requested);
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_LT(8.0 * static_cast<double>(messages[0].size()), 2.5 * blocks_of(requested));
}

TEST(AskCoder, TheLightOfACurveCostsLittle) {
  const std::vector<RequestedTile> requested = circle_blocks({1024, 1024}, 2);
  const auto messages = requested_messages({1024, 1024}, Side::Right, 3, requested);
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_LT(8.0 * static_cast<double>(messages[0].size()), 3.0 * blocks_of(requested));
}

TEST(AskCoder, ALostSliceLeavesItsTilesUnknown) {
  std::mt19937 random(3);
  const Extent size{512, 512};
  const std::vector<RequestedTile> requested = noise_requested(size, 3, random);
  const auto messages = requested_messages(size, Side::Left, 3, requested);
  ASSERT_GT(messages.size(), 1u);
  Collected collected(size);
  for (std::size_t i = 1; i < messages.size(); ++i) ASSERT_TRUE(collected.take(messages[i]));
  const std::uint32_t gone = std::get<AskSlice>(*decode_client(messages[0])).tile_count;
  for (std::uint32_t tile = 0; tile < requested.size(); ++tile) {
    EXPECT_EQ(collected.known[tile], tile < gone ? 0 : 1);
    EXPECT_EQ(collected.requested[tile], tile < gone ? RequestedTile{} : requested[tile]);
  }
}

/// They are refused and nothing changes, or they are accepted: then what they ask for has only shares that
/// exist. Returns 1 if they are accepted.
std::size_t expect_harmless_ask(const Bytes& bytes, Extent size) {
  const Decoded<ClientMessage> message = decode_client(bytes);
  if (!message || !std::holds_alternative<AskSlice>(*message)) return 0;
  Collected collected(size);
  if (!collected.take(bytes)) {
    EXPECT_EQ(collected.requested, Collected(size).requested);
    EXPECT_EQ(collected.known, Collected(size).known);
    return 0;
  }
  const std::uint32_t shares = shares_of(std::get<AskSlice>(*message).lights);
  for (const RequestedTile& tile : collected.requested)
    for (std::uint32_t share = shares; share < kMostShares; ++share) EXPECT_EQ(tile.shares[share], kNoBlocks);
  return 1;
}

TEST(AskCoder, NearlyEveryTruncationIsRefused) {
  std::mt19937 random(4);
  const Extent size{200, 200};
  std::size_t accepted = 0, cuts = 0;
  for (const std::uint32_t lights : {1u, 3u, 9u})
    for (const Bytes& whole :
         requested_messages(size, Side::Left, lights, noise_requested(size, lights, random)))
      for (std::size_t length = 0; length < whole.size(); ++length, ++cuts)
        accepted += expect_harmless_ask(
            Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length)), size);
  EXPECT_LE(accepted, cuts / 50);
}

TEST(AskCoder, EveryFlippedBitIsHarmless) {
  std::mt19937 random(5);
  const Extent size{80, 80};
  for (const std::uint32_t lights : {1u, 3u, 9u})
    for (const Bytes& whole :
         requested_messages(size, Side::Left, lights, noise_requested(size, lights, random)))
      for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
        Bytes flipped = whole;
        flipped[bit / 8] ^= std::byte{1} << bit % 8;
        expect_harmless_ask(flipped, size);
      }
}

TEST(AskCoder, TheLastBlockOfATileIsNotCodedWhereTheOthersSayIt) {
  // Some blocks of each tile are asked for: the last one if no other is, and not if all others are.
  const std::vector<RequestedTile> requested{
      {.shares = {0x8000}}, {.shares = {0x7fff}}, {.shares = {0x8000}}, {.shares = {0x7fff}}};
  const Bytes bytes = requested_messages({64, 16}, Side::Left, 1, requested).at(0);
  const AskSlice slice = std::get<AskSlice>(*decode_client(bytes));
  EXPECT_EQ(Bytes(slice.block.begin(), slice.block.end()), bytes_of({0xc0, 0x21, 0x4b, 0x89}));
}

TEST(AskCoder, RefusesAnotherGridAndBytesAfterTheLastTile) {
  Bytes bytes =
      requested_messages({32, 32}, Side::Left, 3, std::vector<RequestedTile>(4, {.shares = {0x0360}})).at(0);
  EXPECT_EQ(Collected({48, 32}).take(bytes).error(), WireRefusal::OtherMask);
  bytes.push_back({});
  EXPECT_EQ(Collected({32, 32}).take(bytes).error(), WireRefusal::Block);
}

TEST(AskCoder, RefusesMoreLightsThanAMaskHas) {
  Bytes bytes = requested_messages({32, 32}, Side::Left, kMaxLights, std::vector<RequestedTile>(4)).at(0);
  EXPECT_EQ(std::get<AskSlice>(*decode_client(bytes)).lights, kMaxLights);
  bytes[10] = std::byte{1};  // 257 lights
  EXPECT_EQ(decode_client(bytes).error(), WireRefusal::Lights);
}

}  // namespace
}  // namespace farshade
