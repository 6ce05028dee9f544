/// Which surfaces are a sky, and what follows: no shadow, and no wall for whoever looks for a place.
#include "stereo/scene/sky.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "stereo/placement/surroundings.h"
#include "stereo/scene/scene_hash.h"
#include "stereo/scene/viewpoint.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

/// A sphere of `radius` about the origin from the `lowest` elevation up; its triangles face inside or
/// outside.
Mesh dome(float radius, double lowest_rad, bool inwards) {
  constexpr int kAround = 16, kUp = 8;
  const auto at = [&](int around, int up) {
    const double elevation = std::lerp(lowest_rad, std::numbers::pi / 2, up / double{kUp});
    const double azimuth = 2 * std::numbers::pi * around / kAround;
    return radius * glm::vec3(std::cos(elevation) * std::cos(azimuth), std::sin(elevation),
                              std::cos(elevation) * std::sin(azimuth));
  };
  std::vector<glm::vec3> corners;
  for (int up = 0; up < kUp; ++up)
    for (int around = 0; around < kAround; ++around) {
      const glm::vec3 a = at(around, up), b = at(around + 1, up), c = at(around + 1, up + 1),
                      d = at(around, up + 1);
      for (const glm::vec3& p : inwards ? std::vector{a, b, c, a, c, d} : std::vector{a, c, b, a, d, c})
        corners.push_back(p);
    }
  return triangle_soup(corners);
}

constexpr double kSphere = -std::numbers::pi / 2;

Material without_light() {
  Material material;
  material.unlit = true;
  return material;
}

Material of_colour(const glm::vec4& color) {
  Material material;
  material.base_color = color;
  return material;
}

/// A floor, a box, and the `shells` of one material; the sky is looked for.
Scene scene_in(const std::vector<Mesh>& shells, const Material& material, const glm::dvec3& shift = {},
               float floor = 4) {
  SceneBuilder builder(shift);
  builder.add(quad({0, 0, 0}, {0, 0, floor}, {floor, 0, 0}));
  builder.add(box({0, 0.5f, 0}, {0.5f, 0.5f, 0.5f}));
  const std::uint32_t of_shells = builder.material(material);
  for (const Mesh& mesh : shells) builder.add(mesh, of_shells);
  builder.directional_light({0.3, -1, 0.2});
  Scene scene = builder.build();
  find_sky(scene);
  return scene;
}

std::vector<bool> casting(const Scene& scene) {
  std::vector<bool> casts;
  for (const Instance& instance : scene.instances) casts.push_back(instance.casts);
  return casts;
}

TEST(Sky, IsAnUnlitShellAroundEverythingThatIsLit) {
  for (const bool inwards : {true, false})
    for (const glm::dvec3& shift : {glm::dvec3(0.0), glm::dvec3(1e6, -1e5, 3e5)})
      EXPECT_EQ(casting(scene_in({dome(50, kSphere, inwards)}, without_light(), shift)),
                (std::vector{true, true, false}));
  EXPECT_EQ(casting(scene_in({dome(50, 0, true)}, without_light())), (std::vector{true, true, false}))
      << "a dome that is open below";
  EXPECT_EQ(casting(scene_in({dome(50, kSphere, true), dome(40, kSphere, false)}, without_light())),
            (std::vector{true, true, false, false}))
      << "clouds and sky";
  std::vector<Mesh> faces;
  for (const float side : {-20.0f, 20.0f}) {
    faces.push_back(quad({side, 0, 0}, {0, 20, 0}, {0, 0, 20}));
    faces.push_back(quad({0, side, 0}, {20, 0, 0}, {0, 0, 20}));
    faces.push_back(quad({0, 0, side}, {20, 0, 0}, {0, 20, 0}));
  }
  EXPECT_EQ(casting(scene_in(faces, without_light())),
            (std::vector{true, true, false, false, false, false, false, false}))
      << "a box of six quads";
}

std::vector<Mesh> tiles_of(const Mesh& mesh, std::size_t triangles) {
  std::vector<Mesh> tiles;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += triangles) {
    std::vector<glm::vec3> corners;
    for (std::size_t t = i; t < std::min(i + triangles, mesh.triangles.size()); ++t)
      for (int k = 0; k < 3; ++k) corners.push_back(mesh.positions[mesh.triangles[t][k]]);
    tiles.push_back(triangle_soup(corners));
  }
  return tiles;
}

TEST(Sky, HasTilesCloudsAndASun) {
  std::vector<Mesh> tiles = tiles_of(dome(50, kSphere, true), 8);
  ASSERT_GE(tiles.size(), 32u) << "each fills less than 4 % of the directions";
  std::vector<bool> expected(tiles.size() + 2, false);
  expected[0] = expected[1] = true;
  EXPECT_EQ(casting(scene_in(tiles, without_light())), expected);
  const Mesh disc = quad({12, 40, 8}, {3, 0, 0}, {0, 0, 3}), tree = quad({8, 2, 0}, {0, 2, 0}, {0, 0, 2});
  EXPECT_EQ(casting(scene_in({dome(50, kSphere, true), disc, tree}, without_light())),
            (std::vector{true, true, false, false, true}));
}

TEST(Sky, NeedNotReachTheEndsOfTheGround) {
  EXPECT_EQ(casting(scene_in({dome(50, 0, true)}, without_light(), {}, 70)),
            (std::vector{true, true, false}));
  EXPECT_EQ(casting(scene_in({dome(500, 0.05, true)}, without_light())), (std::vector{true, true, false}))
      << "25 m above the ground";
  EXPECT_EQ(casting(scene_in({dome(50, 0, false)}, without_light(), {}, 70)), std::vector(3, true))
      << "a house on its ground is seen from outside";
}

TEST(Sky, MayBeHiddenAtFirst) {
  SceneBuilder builder;
  builder.add(quad({0, 0, 0}, {0, 0, 4}, {4, 0, 0}));
  const std::uint32_t node = builder.add(dome(50, kSphere, true), builder.material(without_light()));
  Scene scene = builder.build();
  scene.channels = {{.node = node,
                     .path = Path::Visible,
                     .interpolation = Interpolation::Step,
                     .keys_s = {0, 1},
                     .values = {glm::vec4(0.0f), glm::vec4(1, 0, 0, 0)}}};
  scene.animation_length_s = 2;
  scene.instances[1].shown_with = node;
  find_sky(scene);
  EXPECT_EQ(casting(scene), (std::vector{true, false}));
}

TEST(Sky, IsABlackShellThatGlowsToo) {
  Material black = of_colour({0, 0, 0, 1});
  EXPECT_EQ(casting(scene_in({dome(50, kSphere, false)}, black)), std::vector(3, true)) << "a black casing";
  black.glows = true;
  const Scene scene = scene_in({dome(50, kSphere, false)}, black);
  EXPECT_EQ(casting(scene), (std::vector{true, true, false}));
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("is black and closed around everything: it casts no shadow"),
            std::string::npos);
  EXPECT_EQ(casting(scene_in({quad({0, -0.5f, 0}, {0, 0, 60}, {60, 0, 0})}, black)), std::vector(3, true))
      << "black ground";
}

TEST(Sky, IsNothingElse) {
  const auto all_cast = [](const Scene& scene) {
    return std::ranges::all_of(scene.instances, &Instance::casts) && scene.warnings.empty();
  };
  EXPECT_TRUE(all_cast(scene_in({dome(50, kSphere, true)}, Material{}))) << "a lit shell is a room";
  EXPECT_TRUE(all_cast(scene_in({dome(50, 0.5, true)}, without_light())))
      << "a canopy fills a quarter of the sphere";
  EXPECT_TRUE(
      all_cast(scene_in({quad({-20, 0, 0}, {0, 20, 0}, {0, 0, 20}), quad({20, 0, 0}, {0, 20, 0}, {0, 0, 20})},
                        without_light())))
      << "two opposite sides of a box fill a third";
  EXPECT_TRUE(all_cast(scene_in({dome(2, kSphere, true)}, without_light()))) << "the floor reaches out of it";
  EXPECT_TRUE(all_cast(scene_in({quad({0, 8, 0}, {0, 0, 30}, {30, 0, 0})}, without_light()))) << "a ceiling";
  EXPECT_TRUE(all_cast(scene_in({box({1.5f, 0.2f, 0}, {0.2f, 0.2f, 0.2f})}, without_light()))) << "a lamp";
  EXPECT_EQ(
      casting(scene_in({dome(50, kSphere, true), box({1.5f, 0.2f, 0}, {0.2f, 0.2f, 0.2f})}, without_light())),
      (std::vector{true, true, false, true}))
      << "a lamp under the sky";
  Scene alone = scene_in({}, Material{});
  for (Material& material : alone.materials) material.unlit = true;
  find_sky(alone);
  EXPECT_TRUE(all_cast(alone)) << "all is unlit: nothing stands before a sky";
}

TEST(Sky, IsNamedInAWarningAndInTheHash) {
  const Scene scene = scene_in({dome(50, kSphere, true)}, without_light());
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("casts no shadow"), std::string::npos);
  Scene casts = scene;
  casts.instances[2].casts = true;
  EXPECT_NE(hash_of(scene), hash_of(casts));
}

TEST(Sky, IsNoWallOfARoom) {
  const auto viewpoint = [](bool sky) {
    SceneBuilder builder;
    builder.add(quad({0, 0, 0}, {0, 0, 4}, {4, 0, 0}));
    builder.add(box({3.5f, 1.5f, 3.5f}, {0.2f, 1.5f, 0.2f}));
    Material unlit;
    unlit.unlit = true;
    if (sky) builder.add(dome(30, kSphere, true), builder.material(unlit));
    Scene scene = builder.build();
    find_sky(scene);
    return chosen_viewpoint(scene).translation;
  };
  EXPECT_EQ(viewpoint(true), viewpoint(false));
}

TEST(Sky, IsNothingThatRaysMeet) {
  const Scene scene = scene_in({dome(30, kSphere, true)}, without_light());
  const Surroundings surroundings = Surroundings::create(scene).value();
  const std::vector<Ray> rays{{{{0, 3, 0}}, {{0.48, 0.8, 0.36}}}, {{{0, 3, 0}}, {{0, -1, 0}}}};
  EXPECT_EQ(surroundings.first_met(rays)[0].distance_m, kNoSurface_m);
  EXPECT_NEAR(surroundings.first_met(rays)[1].distance_m, 2, 1e-5);
  EXPECT_EQ(surroundings.bounds(), bounds_without_sky(scene));
}

TEST(Sky, IsNoWallForTheViewpoint) {
  const Scene bare = scene_in({}, without_light()),
              below = scene_in({dome(500, kSphere, true)}, without_light());
  EXPECT_EQ(bounds_without_sky(below), bare.bounds);
  EXPECT_EQ(chosen_viewpoint(below).translation, chosen_viewpoint(bare).translation);
  EXPECT_EQ(bounds_without_sky(bare), bare.bounds);
}

}  // namespace
}  // namespace farshade
