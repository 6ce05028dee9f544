#include "stereo/wire/tile_codec.h"

#include <gtest/gtest.h>

#include "tests/unit/wire/samples.h"

namespace farshade {
namespace {

using namespace wire_samples;

constexpr TileRect kTile{0, 0, 16, 16};

/// One tile of one light, given as 16 rows of bits; pixel 0 is the lowest bit.
EyeMask tile_of(const PlaneRows& rows) {
  EyeMask mask({16, 16}, 1);
  for (std::uint32_t y = 0; y < 16; ++y)
    for (std::uint32_t x = 0; x < 16; ++x) mask.set_word(x, y, 0, rows[y] >> x & 1u);
  return mask;
}

Bytes written(const EyeMask& mask) {
  Bytes bytes;
  write_tile(split_tile(mask, kTile, 0), mask.lights(), bytes);
  return bytes;
}

/// The tile after encoding and decoding.
EyeMask travelled(const EyeMask& mask) {
  const Bytes bytes = written(mask);
  ByteReader in(bytes);
  TileBits bits;
  EXPECT_TRUE(read_tile(in, mask.lights(), bits));
  EXPECT_EQ(in.remaining(), 0u);
  EyeMask back(mask.size(), mask.lights());
  merge_tile(bits, kTile, 0, back);
  return back;
}

TEST(TileCodec, OneValueIsCodingAndValue) {
  EyeMask mask({16, 16}, 11);
  for (std::uint32_t i = 0; i < 256; ++i) mask.set_word(i % 16, i / 16, 0, 0x523);
  EXPECT_EQ(written(mask), bytes_of({1, 0x23, 0x05}));
  EXPECT_EQ(travelled(mask), mask);
}

TEST(TileCodec, OneValueOfNoLightsIsCodingAlone) {
  EXPECT_EQ(written(EyeMask({16, 16}, 0)), bytes_of({1}));
}

TEST(TileCodec, AnEdgeIsTheRowsWhereItMoves) {
  PlaneRows rows{};
  for (std::uint32_t y = 4; y < 16; ++y) rows[y] = y < 9 ? 0x03f0 : 0x07e0;
  // varies: light 0; not raw; rows 4 and 9 change: pixels 4 to 9 flip, then 4 and 10 (the run 10..4, within
  // it 5..9).
  EXPECT_EQ(written(tile_of(rows)), bytes_of({2, 1, 0, 0x10, 0x02, 0x94, 0x4a, 0x95}));
  EXPECT_EQ(travelled(tile_of(rows)), tile_of(rows));
}

TEST(TileCodec, LightsThatDoNotVaryCostNoRows) {
  EyeMask mask({16, 16}, 8);
  for (std::uint32_t i = 0; i < 256; ++i) mask.set_word(i % 16, i / 16, 0, i / 16 < 8 ? 0x90 : 0x91);
  EXPECT_EQ(written(mask), bytes_of({2, 0x01, 0x90, 0x00, 0x01, 0xf0}));
  EXPECT_EQ(travelled(mask), mask);
}

TEST(TileCodec, RowsThatFlipEverywhereAreSentRaw) {
  PlaneRows rows;
  for (std::uint32_t y = 0; y < 16; ++y) rows[y] = y % 2 == 0 ? 0x5555 : 0xaaaa ^ 0x0ff0;
  const Bytes bytes = written(tile_of(rows));
  ASSERT_EQ(bytes.size(), 3u + 32u);
  EXPECT_EQ(Bytes(bytes.begin(), bytes.begin() + 7), bytes_of({2, 1, 1, 0x55, 0x55, 0x5a, 0xa5}));
  EXPECT_EQ(travelled(tile_of(rows)), tile_of(rows));
}

TEST(TileCodec, EveryRowOfBitsComesBack) {
  for (std::uint32_t bits = 0; bits < 0x10000; ++bits) {
    PlaneRows rows{};
    rows[3] = static_cast<std::uint16_t>(bits);
    rows[4] = static_cast<std::uint16_t>(~bits);
    ASSERT_EQ(travelled(tile_of(rows)), tile_of(rows)) << "row " << bits;
  }
}

TEST(TileCodec, NoTileIsLongerThanStated) {
  std::mt19937 random(7);
  EXPECT_EQ(written(noise_mask({16, 16}, 32, random)).size(), kMaxTile_bytes);
  for (const std::uint32_t lights : {1u, 8u, 9u, 31u})
    EXPECT_LT(written(noise_mask({16, 16}, lights, random)).size(), kMaxTile_bytes);
}

TEST(TileCodec, PixelsOutsideRepeatTheLastOnes) {
  EyeMask mask({3, 2}, 1);
  mask.set_word(2, 1, 0, 1);
  Bytes bytes;
  write_tile(split_tile(mask, TileGrid{mask.size()}.rect(0), 0), 1, bytes);
  EXPECT_EQ(bytes, bytes_of({2, 1, 0, 0x02, 0x00, 0xf2}));
}

TEST(TileRead, RefusesEveryTruncation) {
  std::mt19937 random(11);
  for (const EyeMask& mask : {noise_mask({16, 16}, 9, random), edge_mask({16, 16}, 9, random)}) {
    const Bytes whole = written(mask);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      ByteReader in(cut);
      TileBits bits;
      EXPECT_EQ(read_tile(in, mask.lights(), bits).error(), WireRefusal::TileLength) << size << " bytes";
    }
  }
}

TEST(TileRead, NotSentLeavesWhatWasThere) {
  Bytes bytes;
  write_not_sent(bytes);
  EXPECT_EQ(bytes, bytes_of({0}));
  ByteReader in(bytes);
  TileBits bits{.varies = 0, .value = 5, .rows = {}};
  EXPECT_EQ(*read_tile(in, 3, bits), TileCoding::NotSent);
  EXPECT_EQ(bits.value, 5u);
}

}  // namespace
}  // namespace farshade
