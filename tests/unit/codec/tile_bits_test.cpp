#include "stereo/codec/tile_bits.h"

#include <gtest/gtest.h>

#include "tests/unit/messages/samples.h"

namespace farshade {
namespace {

using namespace wire_samples;

constexpr TileRect kTile{0, 0, 16, 16};
const RequestedTile kEverything{.shares = {0xffff, 0xffff, 0xffff, 0xffff, 0xffff, 0xffff, 0xffff, 0xffff}};

TEST(TileBits, CellsAreBlocksRowByRow) {
  EyeMask mask({16, 16}, 2);
  mask.set_word(5, 10, 0, 2);  // block 9, column 1 of row 2
  TileBits bits;
  split_tile(mask, kTile, 0, kEverything, bits);
  EXPECT_EQ(bits.varies, 2u);
  EXPECT_EQ(bits.value, 0u);
  TileCells expected{};
  expected[9] = 1u << 9;
  EXPECT_EQ(bits.cells[1], expected);
  EXPECT_EQ(block_bit(5, 10), 1u << 9);
}

TEST(TileBits, MergingGivesTheTileBack) {
  std::mt19937 random(2);
  for (const std::uint32_t lights : {0u, 1u, 8u, 9u, 17u, 32u})
    for (const Extent size : {Extent{16, 16}, Extent{3, 2}, Extent{16, 5}}) {
      const EyeMask mask = noise_mask(size, lights, random);
      TileBits bits;
      split_tile(mask, TileGrid{size}.rect(0), 0, kEverything, bits);
      EyeMask back(size, lights);
      merge_tile(bits, TileGrid{size}.rect(0), 0, kEverything, back);
      EXPECT_EQ(back, mask) << lights << " lights";
    }
}

TEST(TileBits, EachLightIsWrittenOnlyInItsRequestedBlocks) {
  std::mt19937 random(3);
  for (int round = 0; round < 500; ++round) {
    const std::uint32_t lights = 1 + static_cast<std::uint32_t>(random() % 32);
    const EyeMask mask = noise_mask({16, 16}, lights, random), old = noise_mask({16, 16}, lights, random);
    const RequestedTile requested = noise_requested({16, 16}, lights, random)[0];
    TileBits bits;
    split_tile(mask, kTile, 0, requested, bits);
    EyeMask merged = old;
    merge_tile(bits, kTile, 0, requested, merged);
    for (std::uint32_t light = 0; light < lights; ++light)
      for (std::uint32_t y = 0; y < 16; ++y)
        for (std::uint32_t x = 0; x < 16; ++x) {
          const EyeMask& from = (requested.of(light) & block_bit(x, y)) != 0 ? mask : old;
          ASSERT_EQ(merged.lit(x, y, light), from.lit(x, y, light)) << lights << " lights";
        }
  }
}

TEST(TileBits, LightThatIsNotAskedForHasNoValue) {
  EyeMask mask({16, 16}, 3);
  for (std::uint32_t y = 0; y < 16; ++y)
    for (std::uint32_t x = 0; x < 16; ++x) mask.set_word(x, y, 0, x < 4 ? 7 : 4);
  TileBits bits;
  split_tile(mask, kTile, 0, {.shares = {0, 0x0003, 0}}, bits);
  EXPECT_EQ(bits.varies, 2u);
  EXPECT_EQ(bits.value, 0u);
  split_tile(mask, kTile, 0, {.shares = {0x1111, 0x2222, 0}}, bits);
  EXPECT_EQ(bits.varies, 0u);
  EXPECT_EQ(bits.value, 1u);
}

TEST(TileBits, LightThatDiffersOnlyInOtherBlocksDoesNotVary) {
  EyeMask mask({16, 16}, 2);
  for (std::uint32_t y = 0; y < 16; ++y)
    for (std::uint32_t x = 0; x < 16; ++x) mask.set_word(x, y, 0, x < 4 ? 1 : 2);
  TileBits bits;
  split_tile(mask, kTile, 0, all_lights_in(0x1111, 2), bits);
  EXPECT_EQ(bits.varies, 0u);
  EXPECT_EQ(bits.value, 1u);
  split_tile(mask, kTile, 0, all_lights_in(0x0003, 2), bits);
  EXPECT_EQ(bits.varies, 3u);
}

TEST(TileBits, BlocksInsideThePicture) {
  EXPECT_EQ(blocks_in({0, 0, 16, 16}), kAllBlocks);
  EXPECT_EQ(blocks_in({16, 32, 20, 33}), 0x0001);
  EXPECT_EQ(blocks_in({0, 0, 5, 16}), 0x3333);
  EXPECT_EQ(blocks_in({0, 0, 13, 8}), 0x00ff);
}

TEST(TileBits, PixelsOutsideRepeatTheLastOnes) {
  EyeMask mask({3, 2}, 1);
  mask.set_word(2, 1, 0, 1);
  TileBits bits;
  split_tile(mask, TileGrid{mask.size()}.rect(0), 0, kEverything, bits);
  EXPECT_EQ(bits.cells[0][0], 0xccc0);
}

}  // namespace
}  // namespace farshade
