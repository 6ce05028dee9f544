#include "stereo/codec/plane_codec.h"

#include <gtest/gtest.h>

#include <bit>

#include "stereo/codec/plane_tile.h"
#include "tests/support/largest_word.h"
#include "tests/unit/messages/samples.h"

namespace farshade {
namespace {

using namespace wire_samples;

constexpr PlaneKind kKinds[] = {PlaneKind::BaseColor, PlaneKind::Normal, PlaneKind::Depth,
                                PlaneKind::PositionX};

PixelPlane noise_plane(Extent size, std::uint32_t word_bytes, std::mt19937& random) {
  PixelPlane plane(size, word_bytes);
  for (std::uint32_t& word : plane.words)
    word = static_cast<std::uint32_t>(random()) & largest_word(word_bytes);
  return plane;
}

/// The depth of a plane in space; some pixels have no surface.
PixelPlane smooth_plane(Extent size, std::uint32_t word_bytes, std::mt19937& random) {
  PixelPlane plane(size, word_bytes);
  const auto below = [&](std::uint32_t most) { return static_cast<std::uint32_t>(random() % most); };
  const std::uint32_t across = below(64), down = below(64), start = below(1000);
  for (std::uint32_t y = 0; y < size.height; ++y)
    for (std::uint32_t x = 0; x < size.width; ++x)
      plane.words[y * size.width + x] =
          x + 2 * y < 20 ? 0 : (start + across * x + down * y) & largest_word(word_bytes);
  return plane;
}

PixelPlane one_value(Extent size, std::uint32_t word_bytes, std::uint32_t value) {
  PixelPlane plane(size, word_bytes);
  std::ranges::fill(plane.words, value & largest_word(word_bytes));
  return plane;
}

/// The messages of one plane.
std::vector<Bytes> packed_plane(const PixelPlane& plane, PlaneKind kind) {
  PlanePacker packer;
  packer.start(FrameId{41}, Side::Right, kind, plane);
  std::vector<Bytes> messages;
  while (const std::optional<PlaneSlice> slice = packer.next())
    messages.push_back(encoded(ServerMessage(*slice)));
  return messages;
}

std::size_t bytes_in(const std::vector<Bytes>& messages) {
  std::size_t sum = 0;
  for (const Bytes& message : messages) sum += message.size();
  return sum;
}

struct Received {
  PixelPlane plane;
  ReceivedTiles known;
  std::uint32_t learned = 0;

  explicit Received(const PixelPlane& like)
      : plane(like.size, like.word_bytes), known(TileGrid{like.size}.count()) {}

  Decoded<std::uint32_t> take(const Bytes& bytes) {
    const Decoded<ServerMessage> message = decode_server(bytes);
    if (!message) return refuse(message.error());
    const Decoded<std::uint32_t> news = decode_plane_tiles(std::get<PlaneSlice>(*message), plane, known);
    if (news) learned += *news;
    return news;
  }
};

void expect_round_trip(const PixelPlane& plane, PlaneKind kind) {
  Received received(plane);
  std::ranges::fill(received.plane.words, largest_word(plane.word_bytes));
  for (const Bytes& bytes : packed_plane(plane, kind)) {
    ASSERT_LE(bytes.size(), kMaxMessage_bytes);
    ASSERT_TRUE(received.take(bytes));
  }
  EXPECT_EQ(received.plane, plane) << plane.size.width << " x " << plane.size.height;
  EXPECT_EQ(received.learned, received.known.size());
  EXPECT_EQ(received.known, ReceivedTiles(received.known.size(), 1));
}

class PlaneRoundTrip : public testing::TestWithParam<std::uint32_t> {};

TEST_P(PlaneRoundTrip, GivesTheWordsBack) {
  const std::uint32_t seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  for (const PlaneKind kind : kKinds)
    for (const Extent size : {Extent{1, 1}, Extent{16, 16}, Extent{17, 15}, Extent{7, 90}, Extent{83, 50}}) {
      expect_round_trip(noise_plane(size, GetParam(), random), kind);
      expect_round_trip(smooth_plane(size, GetParam(), random), kind);
      expect_round_trip(one_value(size, GetParam(), static_cast<std::uint32_t>(random())), kind);
      expect_round_trip(one_value(size, GetParam(), 0), kind);
      expect_round_trip(one_value(size, GetParam(), ~0u), kind);
    }
}

INSTANTIATE_TEST_SUITE_P(WordBytes, PlaneRoundTrip, testing::Values(1u, 2u, 3u, 4u));

TEST(PlanePacker, TakesTheLongestSides) {
  std::mt19937 random(5);
  for (const Extent size : {Extent{kMaxViewSide_px, 3}, Extent{3, kMaxViewSide_px}})
    expect_round_trip(smooth_plane(size, 4, random), PlaneKind::Depth);
}

TEST(PlanePacker, MakesNoSliceOfNothing) {
  EXPECT_TRUE(packed_plane(PixelPlane{}, PlaneKind::Depth).empty());
}

TEST(PlanePacker, SpendsHardlyAnythingOnOneValue) {
  EXPECT_LT(bytes_in(packed_plane(one_value({512, 512}, 4, 0x3f800001), PlaneKind::Depth)), 200u);
}

/// Values that are linear on the screen, such as the depth of a plane, are predicted up to rounding.
TEST(PlanePacker, SpendsLittleOnWhatIsLinearOnTheScreen) {
  PixelPlane plane({256, 256}, 4);
  for (std::uint32_t y = 0; y < 256; ++y)
    for (std::uint32_t x = 0; x < 256; ++x)
      plane.words[y * 256 + x] = std::bit_cast<std::uint32_t>(1.0f + 1.37e-4f * static_cast<float>(x) +
                                                              2.11e-4f * static_cast<float>(y));
  EXPECT_LT(bytes_in(packed_plane(plane, PlaneKind::Depth)), 256u * 256 * 4 / 8);
}

/// Each channel and each of the two numbers of a normal has its own gradient.
TEST(PlanePacker, LanesDoNotDisturbEachOther) {
  PixelPlane plane({128, 128}, 4);
  for (std::uint32_t i = 0; i < plane.words.size(); ++i)
    plane.words[i] = (i * 2654435761u & 0xffff0000u) | 0x1234;
  const std::size_t as_normal = bytes_in(packed_plane(plane, PlaneKind::Normal));
  for (std::uint32_t& word : plane.words) word &= 0xffff0000u;
  EXPECT_NEAR(static_cast<double>(as_normal),
              static_cast<double>(bytes_in(packed_plane(plane, PlaneKind::Normal))), 500);
}

TEST(PlaneSlices, DecodeInAnyOrderAndTwice) {
  std::mt19937 random(6);
  const PixelPlane plane = noise_plane({96, 96}, 3, random);
  auto messages = packed_plane(plane, PlaneKind::PositionY);
  ASSERT_GT(messages.size(), 4u);
  std::shuffle(messages.begin(), messages.end(), random);
  Received received(plane);
  for (const Bytes& bytes : messages) {
    EXPECT_GT(received.take(bytes).value(), 0u);
    EXPECT_EQ(received.take(bytes).value(), 0u);
  }
  EXPECT_EQ(received.plane, plane);
}

TEST(PlaneSlices, ALostOneLeavesItsTilesUnknownAndNothingElse) {
  std::mt19937 random(8);
  const PixelPlane plane = noise_plane({96, 96}, 4, random);
  const auto messages = packed_plane(plane, PlaneKind::Depth);
  const TileGrid grid{plane.size};
  for (std::size_t lost = 0; lost < messages.size(); ++lost) {
    Received received(plane);
    for (std::size_t i = 0; i < messages.size(); ++i)
      if (i != lost) {
        ASSERT_TRUE(received.take(messages[i]));
      }
    const auto gone = std::get<PlaneSlice>(*decode_server(messages[lost]));
    for (std::uint32_t y = 0; y < 96; ++y)
      for (std::uint32_t x = 0; x < 96; ++x) {
        const std::uint32_t tile = y / 16 * grid.columns() + x / 16;
        const bool unknown = tile - gone.first_tile < gone.tile_count;
        ASSERT_EQ(received.known[tile], unknown ? 0 : 1);
        ASSERT_EQ(received.plane.words[y * 96 + x], unknown ? 0u : plane.words[y * 96 + x]);
      }
  }
}

/// Decoding costs more than the bytes: a few bytes may have thousands of tiles.
TEST(PlaneSlices, AReceivedTileIsNotDecodedAgain) {
  std::mt19937 random(12);
  const PixelPlane plane = noise_plane({96, 96}, 4, random), other = noise_plane({96, 96}, 4, random);
  Received received(plane);
  EXPECT_GT(received.take(packed_plane(plane, PlaneKind::Depth).front()).value(), 0u);
  const PixelPlane once = received.plane;
  Bytes again = packed_plane(other, PlaneKind::Depth).front();
  EXPECT_EQ(received.take(again).value(), 0u);
  again.back() ^= std::byte{1};
  EXPECT_EQ(received.take(again).value(), 0u) << "its block is not even opened";
  EXPECT_EQ(received.plane, once);
}

TEST(PlaneSlices, OfAnotherSizeOrWordAreRefused) {
  std::mt19937 random(9);
  const Bytes message = packed_plane(noise_plane({32, 32}, 3, random), PlaneKind::BaseColor).front();
  for (const PixelPlane& other : {PixelPlane({32, 31}, 3), PixelPlane({32, 32}, 4)}) {
    Received received(other);
    EXPECT_EQ(received.take(message), refuse(WireRefusal::OtherMask));
    EXPECT_EQ(received.plane, other);
  }
}

TEST(PlaneSlices, AreExactlyTheTilesTheyClaim) {
  std::mt19937 random(11);
  const PixelPlane plane = smooth_plane({48, 48}, 3, random);
  PlanePacker packer;
  packer.start(FrameId{}, Side::Left, PlaneKind::PositionX, plane);
  const PlaneSlice whole = packer.next().value();
  ASSERT_EQ(whole.tile_count, 9u);
  Received received(plane);
  for (const std::uint32_t claimed : {1u, 8u}) {
    PlaneSlice fewer = whole;
    fewer.tile_count = claimed;
    EXPECT_EQ(decode_plane_tiles(fewer, received.plane, received.known), refuse(WireRefusal::TileLength));
  }
  PixelPlane larger({64, 48}, 3);
  ReceivedTiles known(12);
  PlaneSlice more = whole;
  more.size = larger.size, more.tile_count = 10;
  EXPECT_EQ(decode_plane_tiles(more, larger, known), refuse(WireRefusal::TileLength));
  EXPECT_EQ(received.plane, PixelPlane(plane.size, 3));
  EXPECT_EQ(known, ReceivedTiles(12));
}

/// A property of all inputs: they are refused and nothing changes, or they are accepted.
void expect_harmless(const Bytes& bytes, const PixelPlane& like) {
  const Decoded<ServerMessage> message = decode_server(bytes);
  if (!message || !std::holds_alternative<PlaneSlice>(*message)) return;
  Received received(like);
  const Received before = received;
  if (received.take(bytes)) {
    for (const std::uint32_t word : received.plane.words) ASSERT_LE(word, largest_word(like.word_bytes));
    return;
  }
  EXPECT_EQ(received.plane, before.plane);
  EXPECT_EQ(received.known, before.known);
}

TEST(PlaneSlices, EveryTruncationIsRefusedAndChangesNothing) {
  std::mt19937 random(10);
  const PixelPlane plane = smooth_plane({64, 64}, 3, random);
  for (const Bytes& whole : packed_plane(plane, PlaneKind::BaseColor))
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      Received received(plane);
      EXPECT_FALSE(received.take(cut)) << size << " of " << whole.size();
      EXPECT_EQ(received.plane, PixelPlane(plane.size, 3));
      EXPECT_EQ(received.known, ReceivedTiles(16));
    }
}

TEST(PlaneSlices, EveryFlippedBitIsHarmless) {
  std::mt19937 random(12);
  const PixelPlane plane = smooth_plane({48, 48}, 4, random);
  for (const Bytes& whole : packed_plane(plane, PlaneKind::Normal))
    for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
      Bytes flipped = whole;
      flipped[bit / 8] ^= std::byte{1} << bit % 8;
      expect_harmless(flipped, plane);
    }
}

TEST(PlaneSlices, BlocksOfNoiseAreHarmless) {
  const std::uint32_t seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  const PixelPlane plane({48, 48}, 2);
  for (int i = 0; i < 20'000; ++i) {
    Bytes tiles(random() % 60);
    for (std::byte& byte : tiles) byte = static_cast<std::byte>(random() % 4 == 0 ? random() : random() % 4);
    const Bytes block = literal_block(tiles);
    expect_harmless(
        encoded(ServerMessage(PlaneSlice{.kind = PlaneKind::Depth,
                                         .size = {48, 48},
                                         .word_bytes = 2,
                                         .tile_count = 1 + static_cast<std::uint32_t>(random() % 4),
                                         .block = block})),
        plane);
  }
}

TEST(PlaneTile, HasThePredictionThatMakesItShorter) {
  const auto prediction_of = [](auto word_at) {
    TileWords words;
    for (std::uint32_t i = 0; i < kTilePixelCount; ++i) words[i] = word_at(i % 16, i / 16);
    Bytes out;
    write_plane_tile(words, {.count = 1, .bits = 16}, out);
    return static_cast<Prediction>(std::to_integer<unsigned>(out.at(0)) >> 6);
  };
  // Each pixel is one more than the gradient says, and far beyond its neighbours.
  EXPECT_EQ(prediction_of([](auto x, auto y) { return x * y; }), Prediction::Gradient);
  // The gradient is wrong on both sides of a diagonal edge, the median on one.
  EXPECT_EQ(prediction_of([](auto x, auto y) { return x + y < 16 ? 0u : 1000u; }), Prediction::Median);
}

TEST(PlaneTile, IsRefusedWhereItClaimsWhatNoLaneHolds) {
  TileWords words;
  const auto read = [&](std::initializer_list<unsigned> values) {
    const Bytes bytes = bytes_of(values);
    ByteReader in(bytes);
    return read_plane_tile(in, lanes_of(PlaneKind::PositionX, 1), words);
  };
  EXPECT_TRUE(read({0, 7}));
  EXPECT_EQ(words, [] {
    TileWords all;
    all.fill(7);
    return all;
  }());
  EXPECT_EQ(read({2 << 6, 7}), refuse(WireRefusal::TileCoding));
  EXPECT_EQ(read({9, 7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}),
            refuse(WireRefusal::TileBits));
  EXPECT_EQ(read({1, 7, 1, 0, 2}), refuse(WireRefusal::TileLength));
  // A single residual of -1, coded as 1, at the second pixel. From there on the gradient continues.
  EXPECT_TRUE(read({1, 7, 1, 0, 2, 0}));
  EXPECT_EQ(words[0], 7u);
  EXPECT_EQ(words[1], 6u);
  EXPECT_EQ(words[2], 5u);
  EXPECT_EQ(words[9], 0xfeu);
}

}  // namespace
}  // namespace farshade
