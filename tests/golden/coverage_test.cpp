/// The rasteriser covers the pixels whose rays meet a surface, also with single-sided materials, mirrored
/// instances and holes. Masks with two planes shade with all lights.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "stereo/math/rotation.h"
#include "tests/golden/test_rig.h"
#include "tests/oracle/oracle.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

/// Numbers of pixels of both eyes: covered by the client or the rays alone, and covered by both.
struct Coverage {
  std::size_t apart = 0, common = 0, pixels = 0;
  [[nodiscard]] double apart_share() const {
    return static_cast<double>(apart) / static_cast<double>(pixels);
  }
};

Coverage coverage_of(TestRig& rig, const StereoView& views) {
  const Shown shown = rig.show(views, {});
  Scene unlit = rig.scene();
  unlit.lights.clear();
  Coverage coverage;
  for (const Side side : kSides) {
    const oracle::Masks truth = oracle::trace(unlit, state_at(unlit, Time{}), views[index_of(side)]);
    const std::vector<std::uint8_t>& sources = shown.reports[index_of(side)].sources;
    for (std::size_t i = 0; i < sources.size(); ++i) {
      const bool drawn = sources[i] != kSourceUncovered, met = truth.covered[i] != 0;
      coverage.apart += drawn != met;
      coverage.common += drawn && met;
    }
    coverage.pixels += sources.size();
  }
  return coverage;
}

class CoverageOf : public OnLavapipe {};

TEST_F(CoverageOf, RoomAgreesWithRays) {
  TestRig rig(device_, bundled("room.glb"), 192);
  const Coverage coverage = coverage_of(rig, rig.eyes(rig.head()));
  EXPECT_LE(coverage.apart_share(), 5e-4);
  EXPECT_GT(coverage.common, coverage.pixels / 2);
}

/// A record of the report is then as small as can be, and must not reach into the next one.
TEST_F(CoverageOf, ASceneWithoutLightsAgreesWithRays) {
  SceneBuilder builder;
  for (int i = 0; i < 9; ++i) builder.add(quad({0.2 * i - 0.8, 0, -2}, {0.05, 0, 0}, {0, 0.7, 0}));
  TestRig rig(device_, builder.build(), 96);
  const Coverage coverage = coverage_of(rig, rig.eyes({{1, 0, 0, 0}, {0, 0, 0}}));
  EXPECT_EQ(coverage.apart, 0u);
  EXPECT_GT(coverage.common, coverage.pixels / 8);
}

/// Tracer and rasteriser have one rule for transforms that flatten.
TEST_F(CoverageOf, AFlattenedThingIsThereForBothOrForNone) {
  for (const auto& [outer, inner, is_there] :
       {std::tuple(glm::dvec3(3000, 1, 3000), glm::dvec3(1, 0, 1), false),
        {glm::dvec3(1), glm::dvec3(3000, 0, 3000), true},
        {glm::dvec3(1, 0, 1), glm::dvec3(3000, 3000, 0), false}})
    for (const bool moves : {false, true}) {
      SceneBuilder builder;
      builder.add(box({0, 0, 0}, {0.001, 0.001, 0.001}), 0, scaled(inner));
      builder.point_light({0, 3, 0});
      Scene scene = builder.build();
      NodeTransform place = scaled(outer);
      place.translation = {0, -1, -3};
      scene.nodes.insert(scene.nodes.begin(),
                         {.name = "outer", .parent = {}, .rest = place, .moving = false});
      scene.nodes[1].parent = 0u, scene.nodes[1].moving = moves;
      scene.instances[0].node = 1, scene.lights[0].node = 2;
      if (moves) {
        const glm::vec4 still(glm::vec3(inner), 0);
        scene.channels.push_back(
            {.node = 1, .path = Path::Scale, .keys_s = {0, 1}, .values = {still, still}});
        scene.animation_length_s = 1;
      }
      TestRig rig(device_, scene, 96);
      const StereoView views = rig.eyes({{1, 0, 0, 0}, {0, 0, 0}});
      const Shown shown = rig.show(views, {});
      const auto drawn = std::ranges::count_if(shown.reports[0].sources,
                                               [](auto source) { return source != kSourceUncovered; });
      const Mask traced = rig.trace(kNow, views);
      std::size_t lit = 0;
      for_pixels(views[0].size,
                 [&](std::uint32_t x, std::uint32_t y) { lit += traced.bits[0].word(x, y) != 0 ? 1u : 0u; });
      EXPECT_EQ(drawn > 500, is_there) << moves << ", " << drawn;
      EXPECT_EQ(lit > 500, is_there) << moves << ", " << lit;
    }
}

TEST_F(CoverageOf, AHiddenThingIsThereForNone) {
  for (const bool is_shown : {false, true}) {
    SceneBuilder builder;
    const std::uint32_t node = builder.add(box({0, 0, -3}, {1, 1, 1}));
    builder.point_light({0, 3, 0});
    Scene scene = builder.build();
    scene.channels = {{.node = node,
                       .path = Path::Visible,
                       .interpolation = Interpolation::Step,
                       .keys_s = {0},
                       .values = {glm::vec4(is_shown ? 1.0f : 0.0f)}}};
    scene.animation_length_s = 1;
    scene.instances[0].shown_with = node;
    TestRig rig(device_, scene, 96);
    const StereoView views = rig.eyes({{1, 0, 0, 0}, {0, 0, 0}});
    const auto drawn = std::ranges::count_if(rig.show(views, {}).reports[0].sources,
                                             [](auto source) { return source != kSourceUncovered; });
    EXPECT_EQ(drawn > 500, is_shown) << drawn;
    EXPECT_EQ(coverage_of(rig, views).apart, 0u);
  }
}

/// A quad whose parent is flattened in y by `scale`. The quad is turned out of the parent's plane, so that
/// the parent flattens it into that plane. A box casts on it.
Scene flattened_by_parent(double scale, double size, bool moves) {
  SceneBuilder builder;
  const glm::dvec3 far_off = glm::dvec3(20, 20, 20) / size;  // from the mesh's origin
  builder.add(quad(far_off, {1 / size, 0, 0}, {0, 0, -1 / size}));
  builder.add(box({0.1, -0.1, -3}, {0.1, 0.02, 0.1}));
  builder.point_light({0.3, 2, -2.5});
  Scene scene = builder.build();
  NodeTransform outer = scaled(glm::dvec3(size, scale * size, size)), inner;
  outer.rotation = rotation_exp({0.4, 0.2, 0.3});
  outer.translation = {0, -0.5, -3};
  inner.rotation = rotation_exp({0.5, 0.1, 0});
  inner.translation = -(inner.rotation * far_off);
  scene.nodes.insert(scene.nodes.begin(), {.name = "outer", .parent = {}, .rest = outer, .moving = false});
  scene.nodes[1] = {.name = "inner", .parent = 0u, .rest = inner, .moving = moves};
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i) scene.instances[i].node = i + 1;
  scene.lights[0].node = 3;
  return scene;
}

/// Instances that move are traced in object space, others are not.
TEST_F(CoverageOf, WhatAParentFlattensIsThereForBothIfItMoves) {
  for (const double scale : {1e-4, 1e-6, 1e-7, 1e-8, 1e-9, 1e-12, 0.0, -1e-9})
    for (const double size : {1.0, 3000.0}) {
      SCOPED_TRACE(scale);
      TestRig still(device_, flattened_by_parent(scale, size, false), 96),
          moving(device_, flattened_by_parent(scale, size, true), 96);
      const StereoView views = still.eyes({{1, 0, 0, 0}, {0, 0, 0}});
      const Shown shown = moving.show(views, {});
      const auto drawn = std::ranges::count_if(shown.reports[0].sources,
                                               [](auto source) { return source != kSourceUncovered; });
      const Mask exact = still.trace(kNow, views), traced = moving.trace(kNow, views);
      std::ptrdiff_t lit = 0, wrong = 0;
      for_pixels(views[0].size, [&](std::uint32_t x, std::uint32_t y) {
        const bool is_lit = exact.bits[0].word(x, y) != 0;
        lit += is_lit ? 1 : 0;
        wrong += is_lit != (traced.bits[0].word(x, y) != 0) ? 1 : 0;
      });
      EXPECT_GT(drawn, 1000);
      EXPECT_GT(lit, 800);
      EXPECT_LT(wrong, 20);
    }
}

/// Eyes that are 10 um below a plate see a wall above it, because the near plane cuts the plate off.
TEST_F(CoverageOf, RaysBeginAtTheNearPlaneToo) {
  SceneBuilder builder;
  builder.add(quad({0, 1.2, 0}, {3, 0, 0}, {0, 0, -3}));
  builder.add(quad({0, 1.9, -2}, {2, 0, 0}, {0, 0.6, 0}));
  builder.point_light({0, 2, -1});
  TestRig rig(device_, builder.build(), 96);
  const StereoView views = rig.eyes({{1, 0, 0, 0}, {0, 1.2 - 1e-5, 0}});
  static_cast<void>(rig.show(views, {}));
  const Image<float> distance = rig.renderer().read_distance()[0];
  const Mask traced = rig.trace(kNow, views);
  std::size_t drawn = 0, lit = 0;
  for_pixels(views[0].size, [&](std::uint32_t x, std::uint32_t y) {
    const bool is_wall = distance.at(x, y) > 1;
    drawn += is_wall ? 1u : 0u;
    lit += is_wall && traced.bits[0].word(x, y) != 0 ? 1u : 0u;
  });
  EXPECT_GT(drawn, 500u);
  EXPECT_EQ(lit, drawn);
}

/// The signs of a quad's scale, and whether the quad then faces a viewer at +z.
struct Facing {
  glm::dvec3 scale;
  bool seen;
};

TEST_F(CoverageOf, MirroredSingleSidedQuadsIsAsComputedOnPaper) {
  const std::array facings{Facing{{1, 1, 1}, true},    Facing{{-1, 1, 1}, true},   Facing{{1, -1, 1}, true},
                           Facing{{-1, -1, 1}, true},  Facing{{1, 1, -1}, false},  Facing{{-1, 1, -1}, false},
                           Facing{{1, -1, -1}, false}, Facing{{-1, -1, -1}, false}};
  SceneBuilder builder;
  const std::uint32_t single_sided = builder.material(Material{});
  for (std::size_t i = 0; i < facings.size(); ++i) {
    NodeTransform transform = scaled(facings[i].scale);
    transform.translation = {-1.05 + 0.3 * static_cast<double>(i), 0, 0};
    builder.add(quad({0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}), single_sided, transform);
  }
  builder.point_light({0, 0, 2});
  TestRig rig(device_, builder.build(), 256);
  const StereoView views = rig.eyes({{1, 0, 0, 0}, {0, 0, 2.2}});
  EXPECT_EQ(coverage_of(rig, views).apart, 0u);

  const Shown shown = rig.show(views, {});
  for (const Side side : kSides)
    for (std::size_t i = 0; i < facings.size(); ++i) {
      const View& view = views[index_of(side)];
      const Point<Stage> center{{-1.05 + 0.3 * static_cast<double>(i), 0, 0}};
      const glm::dvec2 at =
          ray_pixel(tangents_of(view.fov), view.size, inverse(view.stage_from_eye)(center).v);
      const auto pixel = static_cast<std::size_t>(at.y) * 256 + static_cast<std::size_t>(at.x);
      EXPECT_EQ(shown.reports[index_of(side)].sources[pixel] != kSourceUncovered, facings[i].seen)
          << "quad " << i << ", " << name_of(side);
    }
}

TEST_F(CoverageOf, MirroredBoxesShowTheirFrontsLit) {
  SceneBuilder builder;
  const std::uint32_t single_sided = builder.material(Material{});
  const std::array scales{glm::dvec3(1, 1, 1), glm::dvec3(-1, 1, 1), glm::dvec3(1, 1, -1),
                          glm::dvec3(-1, -1, -1)};
  for (std::size_t i = 0; i < scales.size(); ++i) {
    NodeTransform transform = scaled(scales[i]);
    transform.translation = {-0.75 + 0.5 * static_cast<double>(i), 0, 0};
    builder.add(box({0, 0, 0}, {0.15, 0.15, 0.15}), single_sided, transform);
  }
  builder.point_light({0, 0, 2});
  TestRig rig(device_, builder.build(), 256);
  const StereoView views = rig.eyes({{1, 0, 0, 0}, {0, 0, 2.05}});
  EXPECT_LE(coverage_of(rig, views).apart_share(), 1e-4);

  const Mask mask = rig.ask(kNow, views);
  const Shown shown = rig.show(views, {mask.traced_mask()});
  const PerEye<Image<float>> distances = rig.renderer().read_distance();
  for (const Side side : kSides)
    for (std::size_t i = 0; i < scales.size(); ++i) {
      const View& view = views[index_of(side)];
      const Point<Stage> front{{-0.75 + 0.5 * static_cast<double>(i), 0, 0.15}};
      const glm::dvec2 at =
          ray_pixel(tangents_of(view.fov), view.size, inverse(view.stage_from_eye)(front).v);
      const auto x = static_cast<std::uint32_t>(at.x), y = static_cast<std::uint32_t>(at.y);
      EXPECT_NEAR(distances[index_of(side)].at(x, y), 1.9, 1e-4) << "box " << i << ", " << name_of(side);
      EXPECT_TRUE(shown.reports[index_of(side)].mask.lit(x, y, 0)) << "box " << i;
      EXPECT_GT(shown.pictures[index_of(side)].at(x, y).r, 50) << "box " << i;
    }
}

TEST_F(CoverageOf, AlphaMaskedLeavesAgreesWithRays) {
  Scene plant = bundled("room.glb");
  std::erase_if(plant.instances, [&](const Instance& instance) {
    return !plant.materials[plant.meshes[instance.mesh].material].alpha_cutoff;
  });
  ASSERT_FALSE(plant.instances.empty());
  const Mesh& leaves = plant.meshes[plant.instances[0].mesh];
  glm::dvec3 middle(0.0);
  for (const glm::vec3& p : leaves.positions) middle += glm::dvec3(p);
  middle = state_at(plant, Time{})
               .stage_from_object[0](Point<Object>{middle / static_cast<double>(leaves.positions.size())})
               .v;
  TestRig rig(device_, std::move(plant), 256);
  const Coverage coverage =
      coverage_of(rig, rig.eyes(head_looking(middle + glm::dvec3(0.5, 0.3, 1.0), middle)));
  EXPECT_GT(coverage.common, 5000u);
  EXPECT_LE(coverage.apart_share(), 2e-3);
}

TEST_F(CoverageOf, FortyLightsShadesFromBothPlanes) {
  const auto picture_of = [&](std::uint32_t lights, bool second_plane) {
    TestRig rig(device_, with_lights(bundled("room.glb"), lights), 128);
    const StereoView views = rig.eyes(rig.head());
    Mask mask = rig.ask(kNow, views);
    for (EyeMask& bits : mask.bits)
      for (std::uint32_t y = 0; y < 128 && lights > 32 && !second_plane; ++y)
        for (std::uint32_t x = 0; x < 128; ++x) bits.set_word(x, y, 1, 0);
    return rig.show(views, {mask.traced_mask()}).pictures;
  };
  const auto first_plane = picture_of(40, false);
  EXPECT_EQ(first_plane, picture_of(32, true)) << "lights 32 to 39 are in the second plane";
  EXPECT_NE(first_plane, picture_of(40, true));
}

}  // namespace
}  // namespace farshade
