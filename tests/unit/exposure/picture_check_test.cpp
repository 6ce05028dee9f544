/// What is said about pictures that are black or white, and about lights that nobody sees.
#include "stereo/exposure/picture_check.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include "stereo/exposure/chosen_exposure.h"
#include "stereo/placement/head_test.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

/// A closed room, seen from its middle.
SceneBuilder walled(const glm::vec4& color = glm::vec4(0.8f, 0.8f, 0.8f, 1.0f)) {
  SceneBuilder builder;
  Material wall;
  wall.double_sided = true;
  wall.base_color = color;
  builder.add(box({0, 1.5f, 0}, {3, 1.5f, 3}), builder.material(wall));
  return builder;
}

std::vector<PictureFinding> findings(const Scene& scene, const Lighting& lighting = {},
                                     const Exposure& exposure = {}) {
  std::vector<Ray> rays;
  for (const Vector<Stage>& direction : directions_around(500)) rays.push_back({{{0, 1.2, 0}}, direction});
  const Surroundings surroundings = Surroundings::create(scene).value();
  return check_picture(surroundings, scene, lighting, exposure, rays);
}

/// As both programs do: the options become part of the scene.
std::vector<PictureFinding> findings_with(Scene scene, const Lighting& lighting) {
  const Scene lit = light_scene(std::move(scene), lighting).value().scene;
  return findings(lit, lighting);
}

bool has(const PictureFinding& finding, std::string_view words) {
  return finding.sentence.find(words) != std::string::npos;
}

/// The number after `words`.
float number_after(const PictureFinding& finding, std::string_view words) {
  const std::size_t at = finding.sentence.find(words);
  return at == std::string::npos ? NAN : std::stof(finding.sentence.substr(at + words.size()));
}

TEST(PictureCheck, SaysNothingOfAPictureThatIsFine) {
  SceneBuilder builder = walled();
  builder.point_light({0, 2.5, 0});
  Scene scene = builder.build();
  scene.lights[0].intensity = glm::vec3(4.0f);
  EXPECT_TRUE(findings(scene).empty());
}

TEST(PictureCheck, SaysNothingIfMostOfThePictureIsBlack) {
  SceneBuilder builder = walled();
  builder.spot_light({0, 2.5, 0}, {1, -0.5, 0}, 0.3f);
  const Scene scene = builder.build();
  EXPECT_TRUE(findings(scene).empty());
  EXPECT_FALSE(findings_with(scene, {.exposure = 1e-9f}).empty()) << "all of it";
}

TEST(PictureCheck, ABlackPictureWithoutLightGetsAmbientLight) {
  SceneBuilder builder = walled();
  builder.spot_light({0, 2.5, 0}, {0, 1, 0}, 0.1f);
  builder.directional_light({0, -1, 0});
  Scene scene = builder.build();
  scene.lights.erase(scene.lights.begin());  // only the sun outside
  const std::vector<PictureFinding> found = findings(scene);
  ASSERT_EQ(found.size(), 1u) << "a room in which nothing stands is no sky";
  EXPECT_TRUE(found[0].is_bad);
  EXPECT_TRUE(has(found[0], "is black, because no light arrives there")) << found[0].sentence;
  EXPECT_EQ(number_after(found[0], "--ambient "), 0.1f);
  EXPECT_TRUE(findings_with(scene, {.ambient = 0.1f}).size() == 1 &&
              !findings_with(scene, {.ambient = 0.1f})[0].is_bad)
      << "the cure works";
}

TEST(PictureCheck, ABlackPictureBecauseOfTheUsersExposureGetsABetterOne) {
  SceneBuilder builder = walled();
  builder.point_light({0, 2.5, 0});
  Scene scene = builder.build();
  scene.lights[0].intensity = glm::vec3(40.0f);
  const std::vector<PictureFinding> found = findings_with(scene, {.exposure = 1e-6f});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].is_bad);
  const float cure = number_after(found[0], "--exposure ");
  EXPECT_GT(cure, 1e-3f) << found[0].sentence;
  EXPECT_TRUE(findings_with(scene, {.exposure = cure}).empty()) << "the cure works";
}

/// As inside of a house whose exposure is that of the garden.
TEST(PictureCheck, AnAlmostBlackPictureGetsABetterExposureToo) {
  SceneBuilder builder = walled();
  builder.point_light({0, 2.5, 0});
  Scene scene = builder.build();
  scene.lights[0].intensity = glm::vec3(64.0f);
  const std::vector<PictureFinding> found = findings(scene, {}, {-60});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(has(found[0], "everything that the head sees is almost black; the cure is --exposure "))
      << found[0].sentence;
  EXPECT_TRUE(findings_with(scene, {.exposure = number_after(found[0], "--exposure ")}).empty());
}

TEST(PictureCheck, BlackMaterialsStayBlack) {
  SceneBuilder builder = walled(glm::vec4(0, 0, 0, 1));
  builder.point_light({0, 2.5, 0});
  const std::vector<PictureFinding> found = findings(builder.build());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(has(found[0], "stays so in any light: its materials have no colour")) << found[0].sentence;
}

TEST(PictureCheck, AWhitePictureGetsAnExposure) {
  SceneBuilder builder = walled();
  builder.point_light({0, 2.5, 0});
  Scene scene = builder.build();
  scene.lights[0].intensity = glm::vec3(1000.0f);
  for (const Lighting& lighting : {Lighting{.exposure = 1.0f}, Lighting{.exposure = 50.0f},
                                   Lighting{.ambient = 2.0f, .exposure = 3.0f}, Lighting{.ambient = 5.0f}}) {
    const std::vector<PictureFinding> found = findings_with(scene, lighting);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_TRUE(found[0].is_bad && has(found[0], "as bright as can be")) << found[0].sentence;
    Lighting cured = lighting;
    cured.exposure = number_after(found[0], "--exposure ");
    EXPECT_TRUE(findings_with(scene, cured).empty()) << *cured.exposure;
    if (!lighting.ambient) {
      EXPECT_NEAR(*cured.exposure, 0.021, 0.004) << "as bright as can be without white";
    }
  }
  EXPECT_TRUE(findings(scene, {}, {-32}).empty()) << "with a chosen exposure";
}

TEST(PictureCheck, TellsWhichThingBlocksALight) {
  SceneBuilder builder;
  builder.add(quad({0, 0, 0}, {0, 0, 4}, {4, 0, 0}));
  builder.add(box({0, 0, 0}, {50, 50, 50}), builder.material(Material{}));
  builder.directional_light({0.2, -1, 0.1});
  builder.point_light({0, 2, 0});
  Scene scene = builder.build();
  scene.nodes[scene.instances[1].node].name = "dome";
  scene.lights[0].name = "sun";
  scene.lights[1].intensity = glm::vec3(3.0f);
  for (Material& material : scene.materials) material.double_sided = true;
  const std::vector<PictureFinding> found = findings(scene);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_FALSE(found[0].is_bad);
  EXPECT_TRUE(has(found[0], "the light 'sun' reaches nothing that the head sees, because 'dome' blocks it"))
      << found[0].sentence;
  EXPECT_TRUE(has(found[0], "KHR_materials_unlit"));
}

TEST(PictureCheck, TellsOfAShellInTwoHalvesToo) {
  SceneBuilder builder;
  builder.add(quad({0, 0, 0}, {0, 0, 4}, {4, 0, 0}));
  builder.add(box({0, 0.5f, 0}, {0.5f, 0.5f, 0.5f}));
  Material both;
  both.double_sided = true;
  const std::uint32_t of_shell = builder.material(both);
  const Mesh shell = box({0, 0, 0}, {50, 50, 50});
  std::array<std::vector<glm::vec3>, 2> halves;  // each with triangles of all sides
  for (std::size_t t = 0; t < shell.triangles.size(); ++t)
    for (int corner = 0; corner < 3; ++corner)
      halves[t % 2].push_back(shell.positions[shell.triangles[t][corner]]);
  for (const std::vector<glm::vec3>& half : halves) builder.add(triangle_soup(half), of_shell);
  builder.directional_light({0.01, -1, 0.01});
  builder.point_light({0, 2, 0});
  Scene scene = builder.build();
  scene.lights[1].intensity = glm::vec3(3.0f);
  const std::vector<PictureFinding> found = findings(scene);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(has(found[0], "KHR_materials_unlit")) << found[0].sentence;
  EXPECT_GT(number_after(found[0], "the light reaches "), 50) << "without both halves";
}

/// Without light, a roof is no sky: that is no cure.
TEST(PictureCheck, NamesNoCureForARoofThatBlocksALight) {
  SceneBuilder builder;
  builder.add(quad({0, 0, 0}, {0, 0, 2}, {2, 0, 0}));
  Material roof;
  roof.double_sided = true;
  builder.add(quad({0, 3, 0}, {0, 0, 40}, {40, 0, 0}), builder.material(roof));
  builder.directional_light({0, -1, 0});
  builder.point_light({0, 2, 0});
  Scene scene = builder.build();
  scene.lights[0].name = "sun";
  scene.lights[1].intensity = glm::vec3(3.0f);
  const std::vector<PictureFinding> found = findings(scene);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(has(found[0], "1 of 2 lights reach nothing that the head sees ('sun')")) << found[0].sentence;
}

TEST(PictureCheck, CountsLightsThatReachNothing) {
  SceneBuilder builder = walled();
  builder.point_light({0, 2.5, 0});
  for (int i = 0; i < 5; ++i) builder.point_light({100.0 + i, 0, 0}, 3.0f);
  Scene scene = builder.build();
  scene.lights[0].intensity = glm::vec3(4.0f);
  for (std::size_t i = 1; i < 6; ++i) scene.lights[i].name = fmt::format("far {}", i);
  const std::vector<PictureFinding> found = findings(scene);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].sentence,
            "5 of 6 lights reach nothing that the head sees ('far 1', 'far 2', 'far 3', ...): without them, "
            "the picture is the same");
}

TEST(PictureCheck, StandsTheBrightestAndTheDarkestLights) {
  for (const float candela : {1e30f, 1e-30f, 1e-44f})
    for (const float exposure : {1e12f, 1.0f, 1e-12f}) {
      SceneBuilder builder = walled();
      builder.point_light({0, 1.2001, 0});
      Scene scene = builder.build();
      scene.lights[0].intensity = glm::vec3(candela);
      for (const PictureFinding& found : findings_with(scene, {.exposure = exposure})) {
        EXPECT_FALSE(has(found, "nan") || has(found, "inf")) << found.sentence;
        EXPECT_TRUE(found.is_bad);
      }
      const Exposure chosen = chosen_exposure(scene);
      EXPECT_LE(std::abs(chosen.quarter_stops), Exposure::kMostQuarterStops);
    }
}

TEST(PictureCheck, SaysNothingWhereAlmostNothingIsSeen) {
  SceneBuilder builder = walled();
  Scene scene = builder.build();
  EXPECT_TRUE(findings(scene).empty()) << "no lights: light_scene adds some";
  builder.directional_light({0, -1, 0});
  scene = builder.build();
  const Surroundings surroundings = Surroundings::create(scene).value();
  const std::vector<Ray> few(15, Ray{{{0, 1.2, 0}}, {{0, -1, 0}}});
  EXPECT_TRUE(check_picture(surroundings, scene, {}, {}, few).empty());
  const std::vector<Ray> enough(16, few[0]);
  EXPECT_FALSE(check_picture(surroundings, scene, {}, {}, enough).empty());
}

}  // namespace
}  // namespace farshade
