#include "vr_client/ask/refresh.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kTiles = 5184;  // of 1152 x 1152 pixels

TEST(Refresh, AsksForEveryTileOnceASecondWhateverTheRate) {
  for (const Duration step : {Duration(13'888'889), Duration(28ms), Duration(130ms), Duration(333ms)}) {
    std::vector<int> turns(kTiles, 0);
    const Time first(-700ms);
    for (Time at = first; at < first + 1s; at += step) {
      std::vector<BlockBits> tiles(kTiles, kNoBlocks);
      add_refresh(at, std::min(at + step, first + 1s), tiles);
      for (std::size_t tile = 0; tile < kTiles; ++tile) turns[tile] += tiles[tile] == kAllBlocks;
    }
    EXPECT_EQ(std::ranges::count(turns, 1), static_cast<std::ptrdiff_t>(kTiles)) << step.count();
  }
}

TEST(Refresh, SpreadsTheTilesOverTimeAndPicture) {
  for (Time at{}; at < Time(1s); at += 28ms) {
    std::vector<BlockBits> tiles(kTiles, kNoBlocks);
    add_refresh(at, at + 28ms, tiles);
    const auto share = [](auto part) {
      return static_cast<double>(std::ranges::count(part, kAllBlocks)) / static_cast<double>(part.size());
    };
    EXPECT_NEAR(share(std::span(tiles)), 0.028, 0.004);
    EXPECT_NEAR(share(std::span(tiles).first(kTiles / 4)), 0.028, 0.004);
  }
}

TEST(Refresh, AsksForAllAfterASecondAndForNothingAtOnce) {
  std::vector<BlockBits> tiles(kTiles, kNoBlocks);
  add_refresh(Time(3s), Time(3s), tiles);
  add_refresh(Time(3s), Time(2s), tiles);
  EXPECT_EQ(std::ranges::count(tiles, kNoBlocks), static_cast<std::ptrdiff_t>(kTiles));
  tiles[7] = 0x0420;
  add_refresh(Time(3s), Time(3100ms), tiles);
  EXPECT_TRUE(tiles[7] == 0x0420 || tiles[7] == kAllBlocks);
  add_refresh(Time(3s), Time(4s), tiles);
  EXPECT_EQ(std::ranges::count(tiles, kAllBlocks), static_cast<std::ptrdiff_t>(kTiles));
}

}  // namespace
}  // namespace farshade
