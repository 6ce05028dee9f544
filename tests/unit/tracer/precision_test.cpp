// The tracer over its stated domain: sizes, distances, distant origins, thin triangles.
#include <gtest/gtest.h>

#include <array>

#include "tests/oracle/agreement.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

constexpr double kMostInFarBand = 0.03;

/// A box over a floor with a near, a grazing and a spot light. `scale` is the size in metres, `shift` the
/// distance from the origin.
Scene box_scene(double scale, const glm::dvec3& shift = glm::dvec3(0.0)) {
  const auto s = static_cast<float>(scale);
  SceneBuilder build(shift);
  build.add(quad({0, 0, 0}, {4 * s, 0, 0}, {0, 0, -4 * s}));
  build.add(box({0, s, 0}, {0.5f * s, 0.5f * s, 0.5f * s}));
  build.point_light(glm::dvec3(1.3, 3.1, 0.4) * scale);
  build.point_light(glm::dvec3(-9.0, 0.002, 0.3) * scale);  // about 89.99 degrees
  build.spot_light(glm::dvec3(0.2, 2.5, -0.3) * scale, {0.1, -1, 0.1}, 0.7f);
  return build.build();
}

StereoView eyes(double scale, const glm::dvec3& shift = glm::dvec3(0.0), std::uint32_t side = 96) {
  const glm::dvec3 target = glm::dvec3(0.02, 0.4, 0.0) * scale + shift;
  return {look(glm::dvec3(0.31, 2.7, 3.3) * scale + shift, target, side),
          look(glm::dvec3(0.39, 2.7, 3.3) * scale + shift, target, side)};
}

TEST(TracerPrecision, HoldsFromAMillimetreToTenKilometres) {
  for (const double scale : {0.000125, 0.01, 1.0, 100.0, 1250.0}) {
    SCOPED_TRACE(scale);
    expect_agrees(box_scene(scale), eyes(scale), Time{}, kMostInFarBand);
  }
}

TEST(TracerPrecision, HoldsAThousandKilometresFromTheOrigin) {
  const glm::dvec3 far(1e6, 1e6, -1e6);
  expect_agrees(box_scene(1, far), eyes(1, far), Time{}, kMostInFarBand);
}

TEST(TracerPrecision, MovingMeshHoldsAThousandKilometresFromTheOrigin) {
  const glm::dvec3 far(1 << 20, 1 << 20, -(1 << 20));
  SceneBuilder build(far);
  build.add(quad({0, 0, 0}, {4, 0, 0}, {0, 0, -4}));
  build.move(build.add(box({0, 1, 0}, {0.5f, 0.5f, 0.5f})), {0.5, 0, 0});
  build.point_light({1.3, 3.1, 0.4});
  expect_agrees(build.build(), eyes(1, far), time_from_ns(500'000'000), kMostInFarBand);
}

/// A square wall across the x axis that moves.
struct Wall {
  glm::dvec3 place;
  double half_m;
  /// The node is turned, and its parent is scaled by this along y and z. A small scale makes the transform
  /// badly conditioned.
  double flat = 1;
};

/// The wall is lit from both sides. The anchor is at the stage's origin, where two small boxes stand.
Scene scene_of(const Wall& wall) {
  SceneBuilder build;
  for (const float x : {-0.5f, 0.5f}) build.add(box({x, 0, 0}, {0.25f, 0.25f, 0.25f}));
  const std::uint32_t parent = build.joint(std::nullopt, wall.place);
  NodeTransform turned;
  turned.rotation = glm::angleAxis(1.0, glm::dvec3(0, 0, 1));
  const double half = wall.half_m / wall.flat;
  const glm::dvec3 up = glm::inverse(turned.rotation) * glm::dvec3(0, half, 0);
  const std::uint32_t node = build.add(quad({}, glm::vec3(up), glm::vec3(0, 0, half)), 0, turned);
  build.move(node, {0, 0, 0.1});
  for (const double x : {-1.0, 1.0}) build.directional_light({x, 0.1, 0.1});
  Scene scene = build.build();
  scene.nodes[parent].rest.scale = {1, wall.flat, wall.flat};
  scene.nodes[node].parent = parent;
  return scene;
}

/// Each eye sees nothing but one side of the wall.
void expect_all_lit(const Wall& wall, const glm::dvec3& seen) {
  SCOPED_TRACE(testing::Message() << seen.x << ", " << wall.half_m << ", " << wall.flat);
  const StereoView views{look(seen + glm::dvec3(1, 0, 0), seen, 64, 1.0),
                         look(seen - glm::dvec3(1, 0, 0), seen, 64, 1.0)};
  const ShadowFrame frame = traced(scene_of(wall), views);
  for (std::uint32_t eye = 0; eye < 2; ++eye) {
    int dark = 0;
    for (std::uint32_t i = 0; i < 64 * 64; ++i) dark += !frame.masks[eye].lit(i % 64, i / 64, eye);
    EXPECT_EQ(dark, 0) << "eye " << eye;
  }
}

/// The error of the transform's inverse is equal for all rays. It may be small or on the harmless side, so
/// the walls are at several places.
TEST(TracerPrecision, AMovingWallHasNoAcneHoweverFarLargeOrSheared) {
  for (const double x : {0.3, 1.7, 3.0}) {
    const glm::dvec3 seen(x, 1000, 0);
    expect_all_lit({.place = seen, .half_m = 1}, seen);
    expect_all_lit({.place = {x, 0, 0}, .half_m = 1100}, seen);
    expect_all_lit({.place = seen, .half_m = 1, .flat = 3e-4}, seen);
  }
}

TEST(TracerPrecision, FarLightActsLikeADirectionalOne) {
  for (const double distance : {100.0, 1e4, 1e7}) {
    SceneBuilder build;
    build.add(quad({0, 0, 0}, {4, 0, 0}, {0, 0, -4}));
    build.add(box({0, 1, 0}, {0.5f, 0.5f, 0.5f}));
    const glm::dvec3 direction = glm::normalize(glm::dvec3(0.3, -1, 0.2));
    build.point_light(-direction * distance);
    build.directional_light(direction);
    SCOPED_TRACE(distance);
    expect_agrees(build.build(), eyes(1), Time{}, kMostInFarBand);
  }
}

TEST(TracerPrecision, LightATenthOfAMillimetreFromItsSurface) {
  SceneBuilder build;
  build.add(quad({0, 0, 0}, {4, 0, 0}, {0, 0, -4}));
  build.point_light({0.01, 0.0001, 0.02});
  const oracle::Agreement sum = expect_agrees(build.build(), eyes(1), Time{}, kMostInFarBand);
  EXPECT_GT(sum.lit, sum.pixel_lights / 2);
}

TEST(TracerPrecision, NeedlesDuplicatesAndPointsDoNoHarm) {
  SceneBuilder build;
  std::vector<glm::vec3> corners;
  for (int i = 0; i < 64; ++i) {  // a floor of needles, 4 m by 4 um; wide needles fill the gaps between them
    const float z = -2 + static_cast<float>(i) / 16, width = 1.0f / 16 - 4e-6f;
    for (const auto& [from, to] : {std::pair{z, z + width}, std::pair{z + width, z + 1.0f / 16}})
      for (const glm::vec3& corner :
           {glm::vec3(-2, 0, to), {2, 0, to}, {2, 0, from}, {-2, 0, to}, {2, 0, from}, {-2, 0, from}})
        corners.push_back(corner);
  }
  const std::vector<glm::vec3> once = corners;
  corners.insert(corners.end(), once.begin(), once.end());
  for (const glm::vec3& p : {glm::vec3(0, 1, 0), {0, 1, 0}, {0, 1, 0}, {0, 1, 0}, {1, 1, 0}, {0.5f, 1, 0}})
    corners.push_back(p);  // a point and a line
  build.add(triangle_soup(corners));
  build.add(box({0, 1, 0}, {0.5f, 0.5f, 0.5f}));
  build.point_light({1.3, 3.1, 0.4});
  const oracle::Agreement sum = expect_agrees(build.build(), eyes(1), Time{}, kMostInFarBand);
  EXPECT_GT(sum.lit, sum.pixel_lights / 5);
}

TEST(TracerPrecision, WideAndLopsidedFov) {
  const Scene scene = box_scene(1);
  const double rad = 0.017453292519943295;
  StereoView views = eyes(1);
  for (const EyeFov fov :
       {EyeFov{-85 * rad, 85 * rad, 85 * rad, -85 * rad}, EyeFov{-50 * rad, 20 * rad, 5 * rad, -44 * rad},
        EyeFov{-0.5 * rad, 0.5 * rad, 0.5 * rad, -0.5 * rad},
        EyeFov{5 * rad, 20 * rad, -3 * rad, -9 * rad}}) {
    views[0].fov = fov;
    views[1].size = {37, 21};
    SCOPED_TRACE(fov.left_rad);
    expect_agrees(scene, views, Time{}, kMostInFarBand);
  }
}

TEST(TracerPrecision, SphereHasNoAcne) {
  SceneBuilder build;
  std::vector<glm::vec3> corners;
  const auto at = [](int i, int j) {
    const float theta = 3.14159265f * static_cast<float>(i) / 24,
                phi = 6.2831853f * static_cast<float>(j) / 48;
    return glm::vec3(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
  };
  for (int i = 0; i < 24; ++i)
    for (int j = 0; j < 48; ++j)
      for (const glm::vec3& p :
           {at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i + 1, j)})
        corners.push_back(p);
  Mesh sphere = triangle_soup(corners);
  for (std::size_t i = 0; i < corners.size(); ++i) sphere.normals[i] = corners[i];
  build.add(sphere);
  build.point_light({3.0, 1.0, 2.0});
  build.point_light({-0.2, 1.0005, 0.1});
  expect_agrees(build.build(), eyes(1), Time{}, kMostInFarBand);
}

}  // namespace
}  // namespace farshade
