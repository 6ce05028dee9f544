#include "stereo/frame/tiles.h"

#include <gtest/gtest.h>

#include <vector>

namespace farshade {
namespace {

TEST(TileGrid, CoversEveryPixelOnce) {
  for (const Extent size : {Extent{1, 1}, Extent{16, 16}, Extent{17, 15}, Extent{100, 33}, Extent{8192, 1}}) {
    const TileGrid grid{size};
    std::vector<int> covered(size.pixels());
    for (std::uint32_t tile = 0; tile < grid.count(); ++tile) {
      const TileRect r = grid.rect(tile);
      ASSERT_LT(r.x0, r.x1);
      ASSERT_LT(r.y0, r.y1);
      for (std::uint32_t y = r.y0; y < r.y1; ++y)
        for (std::uint32_t x = r.x0; x < r.x1; ++x) ++covered.at(std::size_t{y} * size.width + x);
    }
    for (const int times : covered) ASSERT_EQ(times, 1) << size.width << "x" << size.height;
  }
}

TEST(TileGrid, CutsTilesAtTheFarEdges) {
  const TileGrid grid{{40, 20}};
  EXPECT_EQ(grid.columns(), 3u);
  EXPECT_EQ(grid.rows(), 2u);
  const TileRect last = grid.rect(5);
  EXPECT_EQ(last.x0, 32u);
  EXPECT_EQ(last.y0, 16u);
  EXPECT_EQ(last.x1, 40u);
  EXPECT_EQ(last.y1, 20u);
}

TEST(TileGrid, HasNoTilesWithoutPixels) {
  EXPECT_EQ((TileGrid{{0, 0}}.count()), 0u);
}

}  // namespace
}  // namespace farshade
