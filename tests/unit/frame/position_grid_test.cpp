#include "stereo/frame/position_grid.h"

#include <gtest/gtest.h>

#include <limits>

namespace farshade {
namespace {

const View kView{{{0.9, 0.1, 0.4, -0.1}, {1, 2, 3}}, {-0.7, 0.9, 0.8, -0.6}, {40, 30}};

View unit_view() {
  View view = kView;
  view.stage_from_eye.rotation = glm::normalize(view.stage_from_eye.rotation);
  return view;
}

/// Distances whose points are within the scene of grid().
std::vector<float> distances() {
  std::vector<float> result(kView.size.pixels());
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i] = i % 7 == 0 ? 0.0f : 0.5f + 0.001f * static_cast<float>(i);
  return result;
}

PositionGrid grid(std::uint32_t bits) {
  return grid_of({{-4, -3, -2}}, {{6, 7, 8}}, bits);
}

TEST(PositionGrid, StoresPositionsWithinHalfAStep) {
  const View view = unit_view();
  for (const std::uint32_t bits : {8u, 13u, 16u, 24u}) {
    PositionPlanes planes;
    positions_of(view, distances(), grid(bits), planes);
    for (std::uint32_t y = 0; y < 30; ++y)
      for (std::uint32_t x = 0; x < 40; ++x) {
        const std::size_t i = y * 40 + x;
        const glm::dvec3 ray = pixel_ray(tangents_of(view.fov), view.size, {x + 0.5, y + 0.5});
        const glm::dvec3 p = view.stage_from_eye(Point<Eye>{ray * double{distances()[i]}}).v;
        for (int axis = 0; axis < 3; ++axis) {
          const PixelPlane& plane = planes[static_cast<std::size_t>(axis)];
          ASSERT_EQ(plane.word_bytes, bits <= 8 ? 1u : bits <= 16 ? 2u : 3u);
          ASSERT_LT(plane.words[i], 1u << bits);
          ASSERT_EQ(plane.words[i] == 0, i % 7 == 0);
          if (i % 7 == 0) continue;
          const double told = grid(bits).low.v[axis] + (plane.words[i] - 1.0) * grid(bits).step_m;
          ASSERT_NEAR(told, p[axis], grid(bits).step_m * 0.5000001) << bits;
        }
      }
  }
}

TEST(PositionGrid, HoldsTheSceneAndALittleMore) {
  const PositionGrid g = grid(10);
  EXPECT_LT(g.low.v.x, -4.5);
  EXPECT_GT(g.low.v.y + ((1u << 10) - 2.0) * g.step_m, 7.5);
  EXPECT_DOUBLE_EQ(grid_of({{1, 1, 1}}, {{1, 1, 1}}, 10).step_m, 1.125 / 1022);  // a scene without extent
}

TEST(PositionGrid, PositionsOutsideAreNotCovered) {
  const View view = unit_view();
  PositionPlanes planes;
  for (const float distance :
       {1000.0f, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN(), -1.0f}) {
    positions_of(view, std::vector(view.size.pixels(), distance), grid(16), planes);
    for (const PixelPlane& plane : planes) EXPECT_EQ(plane, PixelPlane(view.size, 2)) << distance;
  }
}

TEST(PositionGrid, HoldsItsLastPointAndNothingBeyond) {
  const View ahead{{}, {-0.5, 0.5, 0.5, -0.5}, {1, 1}};  // one pixel that looks along -z
  PositionPlanes planes;
  positions_of(ahead, std::vector{5.0f}, {.low = {{-254, 0, -10}}, .step_m = 1, .bits = 8}, planes);
  EXPECT_EQ(planes[0].words[0], 255u) << "the largest word";
  EXPECT_EQ(planes[1].words[0], 1u);
  EXPECT_EQ(planes[2].words[0], 6u);
  positions_of(ahead, std::vector{5.0f}, {.low = {{-255, 0, -10}}, .step_m = 1, .bits = 8}, planes);
  for (const PixelPlane& plane : planes) EXPECT_EQ(plane.words[0], 0u);
}

TEST(PositionGrid, ReusesItsPlanes) {
  PositionPlanes planes;
  positions_of(unit_view(), distances(), grid(16), planes);
  const std::uint32_t* const words = planes[2].words.data();
  positions_of(unit_view(), distances(), grid(20), planes);
  EXPECT_EQ(planes[2].words.data(), words);
  EXPECT_EQ(planes[2].word_bytes, 3u);
}

}  // namespace
}  // namespace farshade
