// The cells of a triangle: no point of the triangle lies in another cell, or nearer to the light than the
// depth of its cell.
#include "stereo/tracer/cell_cover.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <random>

#include "tests/unit/tracer/cell_place.h"

namespace farshade {
namespace {

constexpr int kSide = 16;

CellFrame cube() {
  CellFrame frame;
  frame.side = kSide;
  frame.origin = {{0.1, -0.2, 0.3}};
  frame.rounding = 1e-6;
  return frame;
}

CellFrame across() {
  CellFrame frame = cube();
  frame.cube = false;
  const glm::dvec3 along = glm::normalize(glm::dvec3(0.3, -1, 0.2));
  const glm::dvec3 u = glm::normalize(glm::cross(glm::dvec3(1, 0, 0), along));
  frame.rows = {u * 2.0, glm::cross(along, u) * 2.0, along};
  return frame;
}

void expect_covers(const CellFrame& frame, double largest, unsigned seed) {
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-2, 2), share(0, 1);
  for (int i = 0; i < 400; ++i) {
    const glm::dvec3 middle(place(random), place(random), place(random));
    const double size = largest * std::pow(share(random), 4);
    std::array<Point<Anchor>, 3> triangle;
    for (Point<Anchor>& p : triangle)
      p = {middle + size * glm::dvec3(place(random), place(random), place(random))};
    std::vector<CellTouch> touched;
    cover(frame, triangle, touched);
    std::map<std::uint32_t, float> depths;
    for (const CellTouch& touch : touched)
      EXPECT_TRUE(depths.emplace(touch.cell, touch.depth).second) << "once each";
    for (int sample = 0; sample < 200; ++sample) {
      const double a = share(random), b = share(random) * (1 - a);
      const Point<Anchor> p = triangle[0] + (triangle[1] - triangle[0]) * a + (triangle[2] - triangle[0]) * b;
      const glm::dvec3 moved(place(random), place(random), place(random));
      const CellTouch truth = place_of(frame, p + Vector<Anchor>{moved * (frame.rounding / 8)});
      const auto found = depths.find(truth.cell);
      ASSERT_NE(found, depths.end()) << "triangle " << i;
      ASSERT_LE(found->second, truth.depth) << "triangle " << i;
    }
  }
}

TEST(CellCover, HoldsEveryPointOfTrianglesAboutACube) {
  expect_covers(cube(), 0.5, 20261122);
}

TEST(CellCover, HoldsEveryPointOfTrianglesAcrossALight) {
  expect_covers(across(), 0.4, 20261123);
}

/// The traversal may treat a triangle as displaced by the frame's rounding.
TEST(CellCover, HoldsPointsThatRoundingHasMoved) {
  CellFrame frame = cube();
  frame.rounding = 0.02;
  expect_covers(frame, 0.5, 20261129);
}

/// Three times the rounding from the light, where a displacement may turn its direction anywhere.
TEST(CellCover, ATriangleThatTouchesTheLightIsInEveryCellOfItsFace) {
  CellFrame frame = cube();
  frame.rounding = 0.02;
  const glm::dvec3 at = frame.origin.v + glm::dvec3(0.06, 0, 0);
  std::vector<CellTouch> touched;
  cover(frame,
        {Point<Anchor>{at - glm::dvec3(0, 0.03, 0.03)},
         {at + glm::dvec3(0, 0.03, 0)},
         {at + glm::dvec3(0, 0, 0.03)}},
        touched);
  EXPECT_EQ(
      std::ranges::count_if(
          touched, [](const CellTouch& touch) { return touch.cell < kSide * kSide && touch.depth == 0; }),
      kSide * kSide);
}

TEST(CellCover, IsTight) {
  // 1.6 m from the light: half a cell wide in the middle of a cell, and over several rows and columns.
  const glm::dvec3 at = cube().origin.v + glm::dvec3(1.6, 0.1, 0.1);
  for (const double half : {0.05, 0.5}) {
    std::vector<CellTouch> touched;
    cover(cube(),
          {Point<Anchor>{at - glm::dvec3(0, half, half)},
           {at + glm::dvec3(0, half, 0)},
           {at + glm::dvec3(0, 0, half)}},
          touched);
    EXPECT_EQ(touched.size() == 1, half < 0.1) << touched.size();
    for (const CellTouch& touch : touched) {
      EXPECT_LE(touch.depth, 1.6);
      EXPECT_GT(touch.depth, 1.6 - 1e-4);
    }
  }
}

}  // namespace
}  // namespace farshade
