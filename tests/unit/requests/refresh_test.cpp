#include "stereo/requests/refresh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kTiles = 5184;  // of 1152 x 1152 pixels
constexpr RequestedTile kAll = all_lights_in(kAllBlocks, 2);
const std::vector<BlockBits> kCovered(kTiles, kAllBlocks);

TEST(Refresh, AsksForEveryTileOnceASecondWhateverTheRate) {
  for (const Duration step : {Duration(13'888'889), Duration(28ms), Duration(130ms), Duration(333ms)}) {
    std::vector<int> turns(kTiles, 0);
    const Time first(-700ms);
    for (Time at = first; at < first + 1s; at += step) {
      std::vector<RequestedTile> tiles(kTiles);
      add_refresh(at, std::min(at + step, first + 1s), 2, kCovered, tiles);
      for (std::size_t tile = 0; tile < kTiles; ++tile) turns[tile] += tiles[tile] == kAll;
    }
    EXPECT_EQ(std::ranges::count(turns, 1), static_cast<std::ptrdiff_t>(kTiles)) << step.count();
  }
}

TEST(Refresh, SpreadsTheTilesOverTimeAndPicture) {
  for (Time at{}; at < Time(1s); at += 28ms) {
    std::vector<RequestedTile> tiles(kTiles);
    add_refresh(at, at + 28ms, 2, kCovered, tiles);
    const auto share = [](auto part) {
      return static_cast<double>(std::ranges::count(part, kAll)) / static_cast<double>(part.size());
    };
    EXPECT_NEAR(share(std::span(tiles)), 0.028, 0.004);
    EXPECT_NEAR(share(std::span(tiles).first(kTiles / 4)), 0.028, 0.004);
  }
}

TEST(Refresh, AsksForAllAfterASecondAndForNothingAtOnce) {
  std::vector<RequestedTile> tiles(kTiles);
  add_refresh(Time(3s), Time(3s), 2, kCovered, tiles);
  add_refresh(Time(3s), Time(2s), 2, kCovered, tiles);
  EXPECT_EQ(std::ranges::count(tiles, RequestedTile{}), static_cast<std::ptrdiff_t>(kTiles));
  const RequestedTile some{{0x0420, 0x0001}};
  tiles[7] = some;
  add_refresh(Time(3s), Time(3100ms), 2, kCovered, tiles);
  EXPECT_TRUE(tiles[7] == some || tiles[7] == kAll);
  add_refresh(Time(3s), Time(4s), 2, kCovered, tiles);
  EXPECT_EQ(std::ranges::count(tiles, kAll), static_cast<std::ptrdiff_t>(kTiles));
}

TEST(Refresh, AsksForNoBlockWithoutASurface) {
  std::vector<RequestedTile> tiles(2);
  const std::vector<BlockBits> covered{kNoBlocks, 0x00f3};
  add_refresh(Time(3s), Time(4s), 2, covered, tiles);
  EXPECT_EQ(tiles[0], RequestedTile{});
  EXPECT_EQ(tiles[1], all_lights_in(0x00f3, 2));
}

}  // namespace
}  // namespace farshade
