#include "stereo/reproject/motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "stereo/math/rotation.h"
#include "stereo/plan/scene_plan.h"
#include "tests/oracle/random_scenes.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

MotionModel model_of(const Scene& scene) {
  return {scene, plan_for(scene).draw.moves};
}

bool is_still(const Motion& motion) {
  return motion.stale_lights.none() && motion.moved.empty();
}

/// How far `inner` extends beyond `outer`, metres.
double beyond(const Sphere& outer, const Sphere& inner) {
  return length(inner.centre - outer.centre) + inner.radius - outer.radius;
}

class Spheres : public testing::Test {
 protected:
  double between(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }
  Sphere any(double spread) {
    return {Point<Stage>{{between(-spread, spread), between(-spread, spread), between(-spread, spread)}},
            between(0, 1)};
  }
  std::mt19937_64 random_{77};  // the seed
};

TEST_F(Spheres, MergedHoldsBothAndIsTheSmallest) {
  int nested = 0;
  for (int i = 0; i < 2000; ++i) {
    const Sphere a = any(i % 2 ? 2.0 : 0.3), b = any(i % 2 ? 2.0 : 0.3), both = merged(a, b);
    ASSERT_LE(beyond(both, a), 1e-12) << "case " << i;
    ASSERT_LE(beyond(both, b), 1e-12) << "case " << i;
    const double apart = length(b.centre - a.centre);
    ASSERT_NEAR(both.radius, std::max({(apart + a.radius + b.radius) / 2, a.radius, b.radius}), 1e-12)
        << "case " << i;
    nested += both.radius == a.radius || both.radius == b.radius;
  }
  EXPECT_GT(nested, 50);
}

TEST_F(Spheres, MergedTakesEqualCentres) {
  const Sphere point{Point<Stage>{{1, 2, 3}}, 0}, ball{Point<Stage>{{1, 2, 3}}, 2};
  EXPECT_EQ(merged(point, point).radius, 0);
  EXPECT_EQ(merged(point, ball).radius, 2);
  EXPECT_EQ(merged(ball, point).radius, 2);
}

TEST_F(Spheres, AddSphereDropsNothing) {
  for (int round = 0; round < 200; ++round) {
    std::vector<Sphere> kept, all;
    for (std::size_t i = 0; i < 3 * kMostSpheres; ++i) {
      all.push_back(any(5));
      add_sphere(all.back(), kept);
      ASSERT_EQ(kept.size(), std::min(all.size(), kMostSpheres));
      for (const Sphere& sphere : all)
        ASSERT_TRUE(std::ranges::any_of(kept, [&](const Sphere& s) { return beyond(s, sphere) < 1e-9; }))
            << "round " << round << ", after " << all.size();
    }
  }
}

TEST_F(Spheres, AddSphereJoinsTheOneThatGrowsLeast) {
  std::vector<Sphere> spheres;
  for (std::size_t i = 0; i < kMostSpheres; ++i)
    add_sphere({Point<Stage>{{10.0 * static_cast<double>(i), 0, 0}}, 1}, spheres);
  add_sphere({Point<Stage>{{21, 0, 0}}, 1}, spheres);
  ASSERT_EQ(spheres.size(), kMostSpheres);
  for (std::size_t i = 0; i < kMostSpheres; ++i) EXPECT_EQ(spheres[i].radius, i == 2 ? 1.5 : 1.0) << i;
}

/// A floor, a box that moves 2 m along +x in a second, and two lights. The second light moves 2 m along +z in
/// a second.
struct Moving {
  Moving() {
    SceneBuilder builder;
    builder.add(quad({0, 0, 0}, {0, 0, 4}, {4, 0, 0}));
    builder.move(builder.add(box({0, 1, 0}, {0.3, 0.4, 0.5})), {2, 0, 0});
    builder.point_light({0, 3, 0});
    builder.move(builder.point_light({1, 3, 0}), {0, 0, 2});
    scene = builder.build();
  }
  [[nodiscard]] Motion between(Duration then, Duration now) const {
    return model_of(scene).between(state_at(scene, Time(then)), state_at(scene, Time(now)));
  }
  Scene scene;
};

TEST(MotionModel, GivesSlotsToWhatCanMoveOnly) {
  const Moving moving;
  const MotionModel model = model_of(moving.scene);
  EXPECT_EQ(model.slots(), (std::vector<std::uint32_t>{0, 1}));
  EXPECT_EQ(model.slot_count(), 1u);
}

TEST(MotionModel, NothingMovesInNoTime) {
  const Moving moving;
  EXPECT_TRUE(is_still(moving.between(300ms, 300ms)));
  EXPECT_TRUE(is_still(moving.between(300ms, 300ms + 1us))) << "the error of a predicted display time";
  EXPECT_TRUE(is_still(moving.between(300ms, 1300ms))) << "the animation repeats";
  EXPECT_FALSE(is_still(moving.between(300ms, 300ms + 1ms)));
  EXPECT_TRUE(is_still(moving.between(300ms + 1us, 300ms)));
  EXPECT_FALSE(is_still(moving.between(300ms + 1ms, 300ms)));
}

TEST(MotionModel, MarksOnlyTheMovedLightStale) {
  const Motion motion = Moving().between(100ms, 300ms);
  EXPECT_FALSE(motion.stale_lights[0]);
  EXPECT_TRUE(motion.stale_lights[1]);
  EXPECT_EQ(motion.stale_lights.count(), 1u);
}

TEST(MotionModel, AChangedConeOrRangeIsStaleAndAChangedIntensityIsNot) {
  SceneBuilder builder;
  builder.add(quad({0, 0, 0}, {1, 0, 0}, {0, 0, -1}));
  builder.point_light({0, 1, 0}, 3.0f);
  builder.change(LightProperty::Intensity, glm::vec4(1), glm::vec4(2));
  builder.change(LightProperty::Color, glm::vec4(1), glm::vec4(0));
  builder.point_light({0, 1, 0}, 3.0f);
  builder.change(LightProperty::Range, glm::vec4(1), glm::vec4(2));
  builder.spot_light({0, 1, 0}, {0, -1, 0}, 1);
  builder.change(LightProperty::OuterCone, glm::vec4(1), glm::vec4(0.5));
  const Scene scene = builder.build();
  const Motion motion = model_of(scene).between(state_at(scene, Time{}), state_at(scene, Time(500ms)));
  EXPECT_EQ(motion.stale_lights.to_ullong(), 6u);
}

TEST(MotionModel, CarriesPointsBackToWhereTheyWere) {
  const Moving moving;
  for (const auto& [then, now] : {std::pair{100ms, 300ms}, std::pair{900ms, 200ms}}) {
    const Motion motion = moving.between(then, now);
    ASSERT_EQ(motion.then_from_now.size(), 1u);
    ASSERT_TRUE(motion.then_from_now[0].has_value());
    const SceneState before = state_at(moving.scene, Time(then)), after = state_at(moving.scene, Time(now));
    for (const glm::vec3& corner : moving.scene.meshes[1].positions) {
      const Point<Object> p{glm::dvec3(corner)};
      const glm::dvec3 carried(*motion.then_from_now[0] * glm::dvec4(after.stage_from_object[1](p).v, 1));
      EXPECT_LT(glm::length(carried - before.stage_from_object[1](p).v), 1e-12);
    }
  }
}

TEST(MotionModel, SpheresHoldTheCasterWhereItWasAndWhereItIs) {
  const Moving moving;
  const Motion motion = moving.between(100ms, 600ms);
  ASSERT_EQ(motion.moved.size(), 2u);
  for (const Duration at : {Duration(100ms), Duration(600ms)})
    for (const glm::vec3& corner : moving.scene.meshes[1].positions) {
      const Sphere point{
          state_at(moving.scene, Time(at)).stage_from_object[1](Point<Object>{glm::dvec3(corner)}), 0};
      EXPECT_TRUE(
          std::ranges::any_of(motion.moved, [&](const Sphere& s) { return beyond(s, point) < 1e-6; }));
    }
  for (const Sphere& sphere : motion.moved)
    EXPECT_NEAR(sphere.radius, std::sqrt(0.3 * 0.3 + 0.4 * 0.4 + 0.5 * 0.5), 1e-6)
        << "and the spheres are no larger";
}

/// A box that is hidden in the second half of each second.
TEST(MotionModel, WhatAppearsOrDisappearsHasMovedAndIsWhereItIsShown) {
  SceneBuilder builder;
  builder.add(quad({0, 0, 0}, {0, 0, 4}, {4, 0, 0}));
  const std::uint32_t node = builder.add(box({0, 1, 0}, {0.3, 0.4, 0.5}));
  Scene scene = builder.build();
  scene.channels.push_back({.node = node,
                            .path = Path::Visible,
                            .interpolation = Interpolation::Step,
                            .keys_s = {0, 0.5, 1},
                            .values = {{1, 0, 0, 0}, {}, {1, 0, 0, 0}}});
  scene.animation_length_s = 1;
  scene.instances[1].shown_with = node;
  const auto between = [&](Duration then, Duration now) {
    return model_of(scene).between(state_at(scene, Time(then)), state_at(scene, Time(now)));
  };
  EXPECT_TRUE(is_still(between(100ms, 400ms)));
  EXPECT_TRUE(is_still(between(600ms, 900ms)));
  for (const auto& [then, now] : {std::pair{400ms, 600ms}, std::pair{600ms, 1200ms}}) {
    const Motion motion = between(then, now);
    EXPECT_EQ(motion.then_from_now.at(0), glm::dmat4(1.0));
    ASSERT_EQ(motion.moved.size(), 1u);
    EXPECT_LT(glm::length(motion.moved[0].centre.v - glm::dvec3(0, 1, 0)), 1e-6);
  }
}

/// The vertices of an instance that a rig deforms, in the stage.
std::vector<glm::dvec3> deformed(const Scene& scene, const SceneState& state, const Instance& instance) {
  const Mesh& mesh = scene.meshes[instance.mesh];
  const Deformation deformation(*mesh.deformable, state.rigs[*instance.rig]);
  const auto number = static_cast<std::size_t>(&instance - scene.instances.data());
  std::vector<glm::dvec3> result;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    result.push_back(
        state.stage_from_object[number](Point<Object>{glm::dvec3(deformation.vertex(i).position)}).v);
  return result;
}

/// Over 40 ms the figures move by up to 12 cm.
TEST(MotionModel, CarriesDeformedPartsBackAndHoldsThemInSpheres) {
  std::mt19937 random{8};  // the seed
  const Scene scene = bending_figures(random, 10'000);
  const SceneState then = state_at(scene, Time(300ms)), now = state_at(scene, Time(340ms));
  const MotionModel model = model_of(scene);
  const Motion motion = model.between(then, now);
  double most_moved = 0, moved_sum = 0, missed_sum = 0;
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    if (!scene.instances[i].rig) continue;
    const auto before = deformed(scene, then, scene.instances[i]),
               after = deformed(scene, now, scene.instances[i]);
    const glm::dmat4& carry = motion.then_from_now.at(model.slots()[i] - 1).value();
    for (std::size_t v = 0; v < before.size(); ++v) {
      const double moved = glm::length(after[v] - before[v]);
      most_moved = std::max(most_moved, moved), moved_sum += moved;
      missed_sum += glm::length(glm::dvec3(carry * glm::dvec4(after[v], 1)) - before[v]);
      for (const glm::dvec3& at : {before[v], after[v]})
        EXPECT_TRUE(std::ranges::any_of(motion.moved, [&](const Sphere& s) {
          return beyond(s, {Point<Stage>{at}, 0}) < 1e-6;
        }));
    }
  }
  EXPECT_GT(most_moved, 0.03);
  EXPECT_LT(missed_sum, 0.05 * moved_sum) << "the affine transforms tell nearly all of the motion";
}

TEST(MotionModel, PartsWhoseJointsStandStillHaveNotMoved) {
  std::mt19937 random{9};  // the seed
  Scene scene = bending_figures(random);
  scene.channels.clear();
  scene.rigs[0].track.reset();
  const MotionModel model = model_of(scene);
  const Motion motion = model.between(state_at(scene, Time(100ms)), state_at(scene, Time(200ms)));
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    if (scene.instances[i].rig != 0u) continue;
    EXPECT_FALSE(motion.then_from_now.at(model.slots()[i] - 1).has_value()) << i;
  }
}

TEST(MotionModel, ManyCastersShareTheSpheresThereAre) {
  SceneBuilder builder;
  for (int i = 0; i < 11; ++i)
    builder.move(builder.add(box({static_cast<float>(i), 1, 0}, {0.1f, 0.1f, 0.1f})), {0, 0.5, 0});
  builder.point_light({0, 3, 0});
  const Scene scene = builder.build();
  const SceneState then = state_at(scene, Time{}), now = state_at(scene, Time(400ms));
  const Motion motion = model_of(scene).between(then, now);
  EXPECT_EQ(motion.moved.size(), kMostSpheres);
  for (std::size_t i = 0; i < scene.instances.size(); ++i)
    for (const SceneState* state : {&then, &now}) {
      const Sphere middle{state->stage_from_object[i](Point<Object>{{static_cast<double>(i), 1, 0}}), 0.17};
      EXPECT_TRUE(
          std::ranges::any_of(motion.moved, [&](const Sphere& s) { return beyond(s, middle) < 0.01; }))
          << "box " << i;
    }
}

TEST(MotionBetweenLightSets, LightsChangedSinceAreStaleAndNoOthers) {
  SceneBuilder build;
  for (int i = 0; i < 4; ++i) build.point_light({0.5 * i, 2, 0});
  const Scene scene = build.build();
  const LightPose elsewhere{Point<Stage>{{3, 3, 3}}, Vector<Stage>{{0, -1, 0}}};
  LightChanges changes;  // revisions 2 to 5
  change(changes, 3, true, elsewhere);
  change(changes, 0, false, std::nullopt);
  change(changes, 1, true, elsewhere);
  change(changes, 2, false, std::nullopt);
  const MotionModel model = model_of(scene);
  const std::array<unsigned long, 5> stale{0b1010, 0b0010, 0b0010, 0,
                                           0};  // a light that is off is never stale
  for (LightSetRevision revision = kFirstLightSet; !is_newer(revision, changes.revision);
       revision = next(revision))
    for (const Duration later : {0ms, 400ms}) {
      const Motion motion = model.between(state_at(scene, Time{}, up_to(changes, revision)),
                                          state_at(scene, Time(later), changes));
      EXPECT_EQ(motion.stale_lights.to_ulong(), stale[revision.value - 1]) << revision.value;
      EXPECT_TRUE(motion.moved.empty());
    }
}

}  // namespace
}  // namespace farshade
