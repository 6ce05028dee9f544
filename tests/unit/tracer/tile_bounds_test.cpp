// The bounds of a tile must hold for each of its points.
#include "stereo/tracer/tile_bounds.h"

#include <gtest/gtest.h>

#include <array>
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

/// The result of the per-pixel test for one point of a tile and its normal.
struct PointTruth {
  bool in_range, in_cone, faces;
};

PointTruth truth_of(const ShadowLight& light, const glm::dvec3& p, const glm::dvec3& normal) {
  const glm::dvec3 axis(light.direction.v);
  const glm::dvec3 to_light = light.kind == LightKind::Directional ? -axis : glm::dvec3(light.position.v) - p;
  return {
      light.kind == LightKind::Directional || glm::length(to_light) < light.range,
      light.kind != LightKind::Spot || -glm::dot(axis, to_light) > light.cos_outer * glm::length(to_light),
      glm::dot(normal, to_light) > 0};
}

/// Random tiles in an empty scene: each verdict holds for every point and normal of the tile.
TEST(TileVerdict, HoldsForEveryPointOfTheTile) {
  const unsigned seed = 20261128;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> place(-1, 1), share(0, 1);
  const auto vector = [&] { return glm::vec3(place(random), place(random), place(random)); };
  const SurfaceModel empty(Scene{}, SceneState{}, TracePlan{});
  const FacetPlanes planes = planes_of(empty);
  std::array<int, 5> verdicts{};
  for (std::size_t i = 0; i < 4000; ++i) {
    ShadowLight light{.kind = std::array{LightKind::Point, LightKind::Spot, LightKind::Directional}[i % 3]};
    light.position = {vector()}, light.direction = {glm::normalize(vector())};
    TileBounds tile;
    tile.points.low = 2.0f * vector();
    tile.points.high = tile.points.low + 0.1f * share(random) * glm::abs(vector());
    tile.starts = tile.points;
    const glm::vec3 normal = glm::normalize(vector()), spread = 0.1f * glm::abs(vector());
    tile.shading = {normal - spread, normal + spread};
    tile.facet = {normal, normal};
    const glm::vec3 from_light = tile.points.low - light.position.v;
    light.range = glm::length(from_light) * (0.9f + 0.2f * share(random));
    const float cosine = glm::dot(from_light, light.direction.v) / glm::length(from_light);
    if (light.kind == LightKind::Spot) light.cos_outer = std::max(cosine + 0.1f * place(random), 0.0f);
    const LightVisibilityMap map(light, planes, empty);
    const TileVerdict verdict = verdict_on(tile, light, &map);
    ++verdicts[static_cast<std::size_t>(verdict)];
    for (int sample = 0; sample < 64; ++sample) {
      const auto in_box = [&](const Box& box) {
        const glm::dvec3 at(share(random), share(random), share(random));
        return glm::dvec3(box.low) + glm::dvec3(box.high - box.low) * (sample % 2 == 0 ? glm::round(at) : at);
      };
      const PointTruth truth = truth_of(light, in_box(tile.points), in_box(tile.shading));
      if (verdict == TileVerdict::Lit) {
        ASSERT_TRUE(truth.in_range && truth.in_cone && truth.faces) << i;
      }
      if (verdict == TileVerdict::OutOfRange) {
        ASSERT_FALSE(truth.in_range) << i;
      }
      if (verdict == TileVerdict::OutOfCone) {
        ASSERT_FALSE(truth.in_cone) << i;
      }
    }
  }
  for (const TileVerdict verdict :
       {TileVerdict::OutOfRange, TileVerdict::OutOfCone, TileVerdict::TurnedAway, TileVerdict::Lit})
    EXPECT_GT(verdicts[static_cast<std::size_t>(verdict)], 50) << static_cast<int>(verdict);
}

/// A level tile of reach 1 at `height` over the plane.
TileBounds level_tile(float height) {
  TileBounds tile;
  tile.starts = {{-1, height, -1}, {1, height, 1}};
  tile.facet = {{0, 1, 0}, {0, 1, 0}};
  tile.along = height;
  tile.reach = 1;
  return tile;
}

TEST(IsBefore, NeedsMoreThanThePlanesTolerance) {
  const LightVisibilityMap::Plane floor{0, 1, 0, 0, 0.01f};
  for (const float height : {-0.02f, 0.005f, 0.02f})
    EXPECT_EQ(is_before(level_tile(height), floor), height > floor.doubt) << height;
}

/// Half of a ray's offset, and an eighth for the rounding of the bounds.
TEST(IsBefore, NeedsMoreThanTheTilesOwnTolerance) {
  constexpr LightVisibilityMap::Plane kCertain{0, 1, 0, 0, 0};
  for (const float offsets : {0.45f, 0.55f, 0.7f})
    EXPECT_EQ(is_before(level_tile(offsets * kOffset), kCertain), offsets > 0.625f) << offsets;
}

}  // namespace
}  // namespace farshade
