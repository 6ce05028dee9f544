// The bounds of a tile must hold for each of its points.
#include "stereo/tracer/tile_bounds.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/unit/tracer/cell_place.h"

namespace farshade {
namespace {

CellFrame cube() {
  CellFrame frame;
  frame.side = LightVisibilityMap::kSide;
  frame.rounding = 32 * 4.0 / (1 << 24);  // coordinates are up to 4
  frame.origin = {{0.125, -0.25, 0.375}};
  return frame;
}

CellFrame across() {
  CellFrame frame = cube();
  frame.cube = false;
  const glm::dvec3 along = glm::normalize(glm::dvec3(0.3, -1, 0.2));
  const glm::dvec3 u = glm::normalize(glm::cross(glm::dvec3(1, 0, 0), along));
  frame.rows = {u * 5.0, glm::cross(along, u) * 5.0, along};
  return frame;
}

/// Expects of random boxes that every corner lies in the cells of its box, at no greater depth than the box.
/// Depths in a map are less by the frame's rounding.
void expect_corners_in_cells(const CellFrame& frame, unsigned seed) {
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> place(-2, 2), share(0, 1);
  int found = 0;
  for (int i = 0; i < 20'000; ++i) {
    Box box;
    box.low = {place(random), place(random), place(random)};
    box.high =
        box.low + std::pow(share(random), 3.0f) * glm::vec3(share(random), share(random), share(random));
    const CellRect rect = cells_of(frame, box);
    if (rect.right < rect.left || rect.bottom < rect.top) continue;
    ++found;
    for (int c = 0; c < 8; ++c) {
      const Point<Anchor> corner{glm::dvec3((c & 1) != 0 ? box.high.x : box.low.x,
                                            (c & 2) != 0 ? box.high.y : box.low.y,
                                            (c & 4) != 0 ? box.high.z : box.low.z)};
      const CellTouch truth = place_of(frame, corner);
      const int number = static_cast<int>(truth.cell);
      const int face = number / (frame.side * frame.side), row = number / frame.side % frame.side,
                column = number % frame.side;
      ASSERT_EQ(face, rect.face) << "box " << i;
      ASSERT_TRUE(column >= rect.left && column <= rect.right) << "box " << i << ", column " << column;
      ASSERT_TRUE(row >= rect.top && row <= rect.bottom) << "box " << i << ", row " << row;
      ASSERT_GE(rect.depth + frame.rounding, truth.depth) << "box " << i;
    }
  }
  EXPECT_GT(found, 5000);
}

TEST(CellsOf, HoldEveryCornerOfABoxInFrontOfACube) {
  expect_corners_in_cells(cube(), 20261126);
}

TEST(CellsOf, HoldEveryCornerOfABoxAcrossALight) {
  expect_corners_in_cells(across(), 20261127);
}

}  // namespace
}  // namespace farshade
