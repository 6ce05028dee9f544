#include "stereo/codec/slice.h"

#include <gtest/gtest.h>

#include "stereo/codec/mask_coder.h"
#include "stereo/codec/range_coder.h"
#include "tests/unit/messages/samples.h"

namespace farshade {
namespace {

using namespace wire_samples;

struct Received {
  EyeMask mask;
  ReceivedTiles known;
  std::uint32_t learned = 0;

  std::vector<RequestedTile> requested;  ///< empty: everything

  explicit Received(const EyeMask& like)
      : mask(like.size(), like.layout()), known(TileGrid{like.size()}.count()) {}

  Decoded<std::uint32_t> take(const Bytes& bytes) {
    const Decoded<ServerMessage> message = decode_server(bytes);
    if (!message) return refuse(message.error());
    const Decoded<std::uint32_t> news = decode_slice_tiles(std::get<Slice>(*message), requested, mask, known);
    if (news) learned += *news;
    return news;
  }
};

class SliceRoundTrip : public testing::TestWithParam<std::uint32_t> {};

void expect_round_trip(const EyeMask& mask) {
  Received received(mask);
  const ShadowFrame frame = frame_of(mask, EyeMask{});
  for (const Bytes& bytes : packed(frame, Side::Left)) {
    ASSERT_LE(bytes.size(), kMaxMessage_bytes);
    ASSERT_TRUE(received.take(bytes));
  }
  EXPECT_EQ(received.mask, mask) << mask.size().width << " x " << mask.size().height;
  EXPECT_EQ(received.learned, mask.layout().planes() * received.known.size());
  for (const std::uint8_t known : received.known) EXPECT_EQ(known, all_planes_received(mask.layout()));
}

TEST_P(SliceRoundTrip, GivesTheMaskBack) {
  const std::uint32_t seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  for (const Extent size : {Extent{1, 1}, Extent{16, 16}, Extent{17, 15}, Extent{7, 90}, Extent{83, 50}}) {
    expect_round_trip(EyeMask(size, GetParam()));
    expect_round_trip(edge_mask(size, GetParam(), random));
    expect_round_trip(noise_mask(size, GetParam(), random));
  }
}

INSTANTIATE_TEST_SUITE_P(Lights, SliceRoundTrip,
                         testing::Values(0u, 1u, 3u, 8u, 9u, 16u, 17u, 32u, 33u, 40u, 256u));

TEST(SlicePacker, TakesTheLongestSides) {
  for (const Extent size : {Extent{kMaxViewSide_px, 3}, Extent{3, kMaxViewSide_px}}) {
    std::mt19937 random(5);
    expect_round_trip(edge_mask(size, 2, random));
  }
}

TEST(SlicePacker, FillsItsMessages) {
  std::mt19937 random(3);
  const ShadowFrame frame = frame_of(EyeMask{}, noise_mask({256, 256}, 3, random));
  for (const std::size_t most : {kBaseMessage_bytes, std::size_t{1333}, kMaxMessage_bytes}) {
    SlicePacker packer;
    packer.start(frame, Side::Right, {}, {}, most);
    std::vector<std::size_t> sizes;
    while (const std::optional<Slice> slice = packer.next()) sizes.push_back(encoded(*slice).size());
    EXPECT_GT(sizes.size(), 10u);
    EXPECT_LE(std::ranges::max(sizes), most);
    for (std::size_t i = 0; i + 1 < sizes.size(); ++i)
      EXPECT_GT(sizes[i] + std::size_t{3} * 32 + 40, most) << "slice " << i;
  }
}

TEST(SlicePacker, MakesWiderWordsNoLonger) {
  std::mt19937 random(6);
  const EyeMask mask = edge_mask({70, 50}, 3, random);
  EyeMask wide(mask.size(), MaskLayout{.lights = 3, .least_word_bytes = 4});
  for (std::uint32_t y = 0; y < mask.size().height; ++y)
    for (std::uint32_t x = 0; x < mask.size().width; ++x) wide.set_word(x, y, 0, mask.word(x, y));
  EXPECT_EQ(wide.bytes().size(), 4 * mask.bytes().size());
  EXPECT_EQ(packed(frame_of(wide, {}), Side::Left), packed(frame_of(mask, {}), Side::Left));
  expect_round_trip(wide);
}

/// Whatever the sender has where nothing is asked for, its slices are the same.
EyeMask with_noise_elsewhere(EyeMask mask, std::span<const RequestedTile> requested, std::mt19937& random) {
  const TileGrid grid{mask.size()};
  for (std::uint32_t y = 0; y < mask.size().height; ++y)
    for (std::uint32_t x = 0; x < mask.size().width; ++x)
      for (std::uint32_t light = 0; light < mask.lights(); ++light)
        if ((requested[y / 16 * grid.columns() + x / 16].of(light) & block_bit(x % 16, y % 16)) == 0)
          mask.set_word(x, y, light / 32,
                        mask.word(x, y, light / 32) ^ (random() % 2 == 0 ? 0u : 1u << light % 32));
  return mask;
}

void expect_requested_bits_of(const EyeMask& mask, const EyeMask& old, const Received& received) {
  const TileGrid grid{mask.size()};
  for (std::uint32_t y = 0; y < mask.size().height; ++y)
    for (std::uint32_t x = 0; x < mask.size().width; ++x)
      for (std::uint32_t light = 0; light < mask.lights(); ++light) {
        const RequestedTile& requested = received.requested[y / 16 * grid.columns() + x / 16];
        const EyeMask& from = (requested.of(light) & block_bit(x % 16, y % 16)) != 0 ? mask : old;
        ASSERT_EQ(received.mask.lit(x, y, light), from.lit(x, y, light)) << x << ", " << y << ", " << light;
      }
}

TEST_P(SliceRoundTrip, GivesTheRequestedBitsBackAndNoOthers) {
  std::mt19937 random(7);
  for (const Extent size : {Extent{1, 1}, Extent{17, 15}, Extent{7, 90}, Extent{83, 50}, Extent{200, 160}}) {
    const EyeMask mask = edge_mask(size, GetParam(), random), old = noise_mask(size, GetParam(), random);
    Received received(mask);
    received.mask = old;
    received.requested = noise_requested(size, GetParam(), random);
    const auto messages = packed(frame_of(mask, {}), Side::Left, received.requested);
    for (const Bytes& bytes : messages) ASSERT_TRUE(received.take(bytes));
    const RequestedTiles tiles(size, GetParam(), received.requested);
    EXPECT_EQ(received.learned, mask.layout().planes() * tiles.count());
    for (std::uint32_t tile = 0; tile < received.known.size(); ++tile)
      EXPECT_EQ(received.known[tile],
                tiles.at(tile).any() != kNoBlocks ? all_planes_received(mask.layout()) : 0);
    expect_requested_bits_of(mask, old, received);
    const EyeMask other = with_noise_elsewhere(mask, received.requested, random);
    EXPECT_EQ(packed(frame_of(other, {}), Side::Left, received.requested), messages);
  }
}

TEST(SlicePacker, ATileWithoutARequestedLightOfAPlaneIsKnownThereToo) {
  std::mt19937 random(11);
  const EyeMask mask = noise_mask({48, 16}, 33, random);  // light 32 alone is plane 1, and in share 0
  Received received(mask);
  received.requested = {{.shares = {0, 0x00ff}}, {}, {.shares = {0, 0x0001}}};
  const auto messages = packed(frame_of(mask, {}), Side::Left, received.requested);
  ASSERT_EQ(messages.size(), 2u);
  EXPECT_EQ(messages[1].size(), kSliceHeader_bytes + 1);
  for (const Bytes& bytes : messages) EXPECT_EQ(received.take(bytes).value(), 2u);
  EXPECT_EQ(received.known, (ReceivedTiles{3, 0, 3}));
}

TEST(SlicePacker, LightsThatAreNotAskedForCostNothing) {
  std::mt19937 random(13);
  const EyeMask alone = edge_mask({96, 96}, 1, random);
  EyeMask mask = noise_mask(alone.size(), 3, random);
  for (std::uint32_t y = 0; y < 96; ++y)
    for (std::uint32_t x = 0; x < 96; ++x)
      mask.set_word(x, y, 0, (mask.word(x, y) & 5u) | alone.word(x, y) << 1);
  std::vector<RequestedTile> requested(36, {.shares = {0, 0x7fff}}),
      requested_alone(36, {.shares = {0x7fff}});
  const auto all = packed(frame_of(mask, {}), Side::Left, requested);
  const auto one = packed(frame_of(alone, {}), Side::Left, requested_alone);
  ASSERT_EQ(all.size(), 1u);
  ASSERT_EQ(one.size(), 1u);
  EXPECT_TRUE(std::ranges::equal(std::span(all[0]).subspan(kSliceHeader_bytes),
                                 std::span(one[0]).subspan(kSliceHeader_bytes)));
}

TEST(RequestedTiles, AreThoseInThePictureAndInSharesOfTheMask) {
  std::vector<RequestedTile> all(4);
  for (RequestedTile& tile : all) tile.shares.fill(kAllBlocks);
  const RequestedTiles tiles({20, 18}, 2, all), every({20, 18}, 2, {});
  EXPECT_EQ(tiles.at(0), all_lights_in(kAllBlocks, 2));
  EXPECT_EQ(tiles.at(1), all_lights_in(0x1111, 2));
  EXPECT_EQ(tiles.at(2), all_lights_in(0x000f, 2));
  EXPECT_EQ(tiles.at(3), all_lights_in(0x0001, 2));
  for (std::uint32_t tile = 0; tile < 4; ++tile) EXPECT_EQ(every.at(tile), tiles.at(tile));
  all[0] = {.shares = {0, 0, 1}};    // a light that the mask does not have
  all[3] = {.shares = {0x8000, 0}};  // a block that the picture does not have
  EXPECT_EQ(RequestedTiles({20, 18}, 2, all).count(), 2u);
  EXPECT_EQ(every.count(), 4u);
}

TEST(SlicePacker, TilesWithoutRequestedBlocksCostNothing) {
  std::mt19937 random(8);
  const EyeMask mask = noise_mask({8192, 512}, 3, random);
  std::vector<RequestedTile> requested(TileGrid{mask.size()}.count());
  EXPECT_TRUE(packed(frame_of(mask, {}), Side::Left, requested).empty());
  requested[100] = requested[9'000] = all_lights_in(0x0001, 3);
  const auto messages = packed(frame_of(mask, {}), Side::Left, requested);
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_LT(messages[0].size(), kSliceHeader_bytes + 25);
  const auto slice = std::get<Slice>(*decode_server(messages[0]));
  EXPECT_EQ(slice.first_tile, 100u);
  EXPECT_EQ(slice.tile_count, 8'901u);
}

TEST(SlicePacker, AnyTileFits) {
  std::mt19937 random(9);
  for (int round = 0; round < 50; ++round) expect_round_trip(noise_mask({16, 16}, 32, random));
  // A checkerboard that changes its phase from light to light: each guess of the coder is wrong.
  EyeMask mask({64, 64}, 32);
  for (std::uint32_t y = 0; y < 64; ++y)
    for (std::uint32_t x = 0; x < 64; ++x)
      mask.set_word(x, y, 0, static_cast<std::uint32_t>(random()) ^ ((x ^ y) % 2 == 0 ? ~0u : 0u));
  expect_round_trip(mask);
}

/// A slice with the first tiles of the mask in plain bits.
Bytes plain_slice(const EyeMask& mask, std::uint32_t tile_count) {
  const TileGrid grid{mask.size()};
  const RequestedTiles requested(mask.size(), mask.lights(), {});
  Bytes block;
  CodedTiles coded;
  TileBits bits;
  coded.start(grid.columns(), 0);
  MaskModels models(kInitialMaskModels);
  RangeEncoder encoder(block);
  MaskCoder coder(encoder, models, coded, mask.layout().lights_in(0));
  coder.form(true);
  for (std::uint32_t tile = 0; tile < tile_count; ++tile) {
    split_tile(mask, grid.rect(tile), 0, requested.at(tile), bits);
    coder.plain_tile(requested.at(tile), bits);
  }
  encoder.finish();
  return encoded(ServerMessage(Slice{
      .size = mask.size(), .lights = mask.lights(), .tile_count = tile_count, .block = std::span(block)}));
}

TEST(Slices, PlainBitsAreThoseOfOneTile) {
  std::mt19937 random(14);
  const EyeMask mask = noise_mask({48, 16}, 3, random);
  EXPECT_EQ(Received(mask).take(plain_slice(mask, 1)), 1u);
  for (const std::uint32_t tiles : {2u, 3u}) {
    Received received(mask);
    EXPECT_EQ(received.take(plain_slice(mask, tiles)).error(), WireRefusal::Block) << tiles;
    EXPECT_EQ(received.mask, EyeMask(mask.size(), mask.layout())) << tiles;
  }
}

TEST(SlicePacker, MakesNoSliceOfNothing) {
  EXPECT_TRUE(packed(frame_of({}, {}), Side::Left).empty());
}

TEST(SlicePacker, StartsAfreshInTheMiddle) {
  std::mt19937 random(4);
  const ShadowFrame frame = frame_of(noise_mask({64, 64}, 8, random), noise_mask({48, 80}, 40, random));
  SlicePacker packer;
  packer.start(frame, Side::Right);
  ASSERT_TRUE(packer.next());
  packer.start(frame, Side::Left);
  std::vector<Bytes> messages;
  while (const std::optional<Slice> slice = packer.next()) messages.push_back(encoded(ServerMessage(*slice)));
  EXPECT_EQ(messages, packed(frame, Side::Left));
}

TEST(Slices, DecodeInAnyOrderAndTwice) {
  std::mt19937 random(6);
  const EyeMask mask = noise_mask({96, 96}, 40, random);
  auto messages = packed(frame_of(mask, {}), Side::Left);
  ASSERT_GT(messages.size(), 4u);
  std::shuffle(messages.begin(), messages.end(), random);
  Received received(mask);
  for (const Bytes& bytes : messages) {
    EXPECT_GT(received.take(bytes).value(), 0u);
    EXPECT_EQ(received.take(bytes).value(), 0u);
  }
  EXPECT_EQ(received.mask, mask);
}

TEST(Slices, ALostOneLeavesItsTilesUnknownAndNothingElse) {
  std::mt19937 random(8);
  const EyeMask mask = noise_mask({96, 96}, 3, random);
  const auto messages = packed(frame_of(mask, {}), Side::Left);
  const TileGrid grid{mask.size()};
  for (std::size_t lost = 0; lost < messages.size(); ++lost) {
    Received received(mask);
    for (std::size_t i = 0; i < messages.size(); ++i)
      if (i != lost) {
        ASSERT_TRUE(received.take(messages[i]));
      }
    const auto gone = std::get<Slice>(*decode_server(messages[lost]));
    for (std::uint32_t y = 0; y < 96; ++y)
      for (std::uint32_t x = 0; x < 96; ++x) {
        const std::uint32_t tile = y / 16 * grid.columns() + x / 16;
        const bool unknown = tile - gone.first_tile < gone.tile_count;
        ASSERT_EQ(received.known[tile], unknown ? 0 : 1);
        ASSERT_EQ(received.mask.word(x, y), unknown ? 0u : mask.word(x, y));
      }
  }
}

TEST(Slices, TilesNotSentStayAsTheyWere) {
  std::mt19937 random(9);
  const EyeMask old = noise_mask({40, 40}, 5, random), mask = noise_mask({40, 40}, 5, random);
  std::vector<std::uint8_t> sent(9, 1);
  sent[0] = sent[4] = 0;
  Received received(mask);
  received.mask = old;
  for (const Bytes& bytes : packed(frame_of(mask, {}), Side::Left, {}, sent))
    ASSERT_TRUE(received.take(bytes));
  EXPECT_EQ(received.known, sent);
  EXPECT_EQ(received.learned, 7u);
  for (std::uint32_t y = 0; y < 40; ++y)
    for (std::uint32_t x = 0; x < 40; ++x)
      ASSERT_EQ(received.mask.word(x, y), (sent[y / 16 * 3 + x / 16] != 0 ? mask : old).word(x, y));
}

/// A property of all inputs: they are refused and nothing changes, or they are accepted.
/// Returns 1 if they are accepted.
std::size_t expect_harmless(const Bytes& bytes, const EyeMask& like,
                            const std::vector<RequestedTile>& requested = {}) {
  const Decoded<ServerMessage> message = decode_server(bytes);
  if (!message || !std::holds_alternative<Slice>(*message)) return 0;
  Received received(like);
  received.requested = requested;
  const Received before = received;
  if (received.take(bytes)) return 1;
  EXPECT_EQ(received.mask, before.mask);
  EXPECT_EQ(received.known, before.known);
  return 0;
}

/// A cut message may be that of other tiles. Its tag tells that it is damaged (seal.h).
TEST(Slices, NearlyEveryTruncationIsRefused) {
  std::mt19937 random(10);
  const EyeMask mask = edge_mask({64, 64}, 9, random);
  std::size_t accepted = 0, cuts = 0;
  for (const auto& requested : {std::vector<RequestedTile>(), noise_requested(mask.size(), 9, random)})
    for (const Bytes& whole : packed(frame_of(mask, {}), Side::Left, requested))
      for (std::size_t size = 0; size < whole.size(); ++size, ++cuts)
        accepted += expect_harmless(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)),
                                    mask, requested);
  EXPECT_LE(accepted, cuts / 50);
}

TEST(Slices, EveryFlippedBitIsHarmless) {
  std::mt19937 random(12);
  const EyeMask mask = edge_mask({48, 48}, 17, random);
  for (const auto& requested : {std::vector<RequestedTile>(), noise_requested(mask.size(), 17, random)})
    for (const Bytes& whole : packed(frame_of(mask, {}), Side::Left, requested))
      for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
        Bytes flipped = whole;
        flipped[bit / 8] ^= std::byte{1} << bit % 8;
        expect_harmless(flipped, mask, requested);
      }
}

TEST(Slices, BlocksOfNoiseAreHarmless) {
  const std::uint32_t seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  const EyeMask mask({48, 48}, 3);
  for (int i = 0; i < 20'000; ++i) {
    Bytes block(random() % 60);
    for (std::byte& byte : block) byte = static_cast<std::byte>(random() % 4 == 0 ? random() : random() % 4);
    const Bytes bytes =
        encoded(ServerMessage(Slice{.size = {48, 48}, .lights = 3, .tile_count = 4, .block = block}));
    expect_harmless(bytes, mask);
    expect_harmless(bytes, mask, noise_requested(mask.size(), 3, random));
  }
}

}  // namespace
}  // namespace farshade
