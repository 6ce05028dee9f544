#include "stereo/edge_rays/caster_triangles.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

/// A triangle that its corners' x tells from others.
Mesh triangle_at(float x) {
  return triangle_soup({{x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0}});
}

CasterTriangles casters_of(const Scene& scene) {
  return caster_triangles(scene, plan_for(scene).draw);
}

/// The corners' places in the stage.
std::vector<glm::dvec3> in_stage(const CasterTriangles& casters) {
  std::vector<glm::dvec3> result;
  for (const std::array<glm::vec3, 3>& corners : casters.corners)
    for (const glm::vec3& corner : corners) result.push_back(casters.origin.v + glm::dvec3(corner));
  return result;
}

TEST(CasterTriangles, ArePlacedInTheStageAlsoFarFromItsOrigin) {
  const glm::dvec3 far(3e6, -2e6, 1e6);
  SceneBuilder builder(far);
  builder.add(triangle_at(2), 0, scaled({2, 3, 1}));
  builder.point_light({0, 0, 2});
  const std::vector<glm::dvec3> corners = in_stage(casters_of(builder.build()));
  const std::vector<glm::dvec3> expected{{4, 0, 0}, {6, 0, 0}, {4, 3, 0}};
  ASSERT_EQ(corners.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_LT(glm::length(corners[i] - far - expected[i]), 1e-6);
}

TEST(CasterTriangles, LeaveOutInstancesThatMoveDoNotCastOrAreSingular) {
  SceneBuilder builder;
  builder.add(triangle_at(0));
  builder.move(builder.add(triangle_at(10)), {1, 0, 0});
  builder.add(triangle_at(20));
  builder.add(triangle_at(30), 0, scaled({0, 0, 1}));
  builder.add(triangle_at(40));
  builder.point_light({0, 0, 2});
  Scene scene = builder.build();
  ASSERT_EQ(scene.instances.size(), 5u);
  scene.instances[2].casts = false;
  const std::vector<glm::dvec3> corners = in_stage(casters_of(scene));
  ASSERT_EQ(corners.size(), 6u);
  EXPECT_NEAR(corners[0].x, 0, 1e-5);
  EXPECT_NEAR(corners[3].x, 40, 1e-5);
}

TEST(CasterTriangles, TellWhichHaveHoles) {
  SceneBuilder builder;
  const std::uint32_t texture = builder.texture({.image = Image<Rgba8>({2, 2})});
  const std::uint32_t leaf = builder.material({.name = "leaf", .texture = texture, .alpha_cutoff = 0.5f});
  builder.add(triangle_at(0));
  builder.add(quad({0, 0, -1}, {1, 0, 0}, {0, 1, 0}), leaf);
  builder.point_light({0, 0, 2});
  EXPECT_EQ(casters_of(builder.build()).has_holes, (std::vector{false, true, true}));
}

TEST(CasterTriangles, KeepTheAlphaOfThoseWithHoles) {
  SceneBuilder builder;
  const Texture texture{.image = Image<Rgba8>({2, 2})};
  static_cast<void>(builder.texture(texture));
  const std::uint32_t leaf = builder.material({.name = "leaf",
                                               .base_color = {1, 1, 1, 0.5f},
                                               .texture = builder.texture(texture),
                                               .alpha_cutoff = 0.25f}),
                      plain = builder.material({.name = "plain", .texture = {}, .alpha_cutoff = 0.75f});
  Mesh with_uvs = triangle_at(10), with_colors = triangle_at(20);
  with_uvs.uvs = {{0, 1}, {2, 3}, {4, 5}};
  for (const int alpha : {0, 51, 255}) with_colors.colors.emplace_back(9, 9, 9, alpha);
  builder.add(triangle_at(0));
  builder.add(with_uvs, leaf);
  builder.add(with_colors, plain);
  builder.point_light({0, 0, 2});
  const std::vector<TriangleAlpha> alphas = casters_of(builder.build()).alphas;
  ASSERT_EQ(alphas.size(), 2u);
  EXPECT_EQ(alphas[0].cutoff, 0.25f);
  EXPECT_EQ(alphas[0].at_corners, (std::array{0.5f, 0.5f, 0.5f}));
  EXPECT_EQ(alphas[0].texture, 1u);
  EXPECT_EQ(alphas[0].uvs, (std::array<glm::vec2, 3>{{{0, 1}, {2, 3}, {4, 5}}}));
  EXPECT_EQ(alphas[1].cutoff, 0.75f);
  EXPECT_EQ(alphas[1].at_corners, (std::array{0.0f, 0.2f, 1.0f}));
  EXPECT_FALSE(alphas[1].texture);
}

TEST(CasterTriangles, HaveNoHolesWithoutACutoff) {
  SceneBuilder builder;
  builder.add(triangle_at(0));
  builder.point_light({0, 0, 2});
  const Scene scene = builder.build();
  DrawPlan plan = plan_for(scene).draw;
  plan.surfaces[0].alpha_test = true;
  const CasterTriangles casters = caster_triangles(scene, plan);
  ASSERT_EQ(casters.alphas.size(), 1u);
  EXPECT_EQ(casters.alphas[0].cutoff, -std::numeric_limits<float>::infinity());
}

}  // namespace
}  // namespace farshade
