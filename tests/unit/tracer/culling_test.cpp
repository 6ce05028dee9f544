// Rays that the tracer skips: skipping changes no bit, and the skipped rays are counted.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "stereo/gltf/gltf.h"
#include "tests/oracle/agreement.h"
#include "tests/oracle/random_scenes.h"
#include "tests/oracle/scene_builder.h"
#include "tests/support/sanitized.h"

namespace farshade {
namespace {

const View kLeftEye = look({0.1, 3.0, 2.9}, {0.03, 0.0, -0.1}, 64);
const View kRightEye = look({0.2, 3.0, 2.9}, {0.03, 0.0, -0.1}, 64);

TracePlan needed_for(const Scene& scene) {
  return plan_for(scene, {.all_lights = true}).trace;
}

TracePlan everything_for(const Scene& scene) {
  return plan_for(scene, {.kind = PlanKind::Everything, .all_lights = true}).trace;
}

struct Traced {
  ShadowFrame frame;
  TraceStats stats;
};

Traced trace_by(const TracePlan& plan, const Scene& scene, const StereoView& views, Time time = {}) {
  Tracer tracer = Tracer::create(scene, plan).value();
  Traced result;
  result.stats = tracer.trace(request_for(views, time), result.frame);
  return result;
}

/// Traces with culling and without, expects the same masks, and returns the counts of the culled trace.
TraceStats expect_same_bits(const Scene& scene, const StereoView& views, Time time = {}) {
  TracePlan plan = needed_for(scene);
  const Traced culled = trace_by(plan, scene, views, time);
  plan.skips_rays = false;
  const Traced whole = trace_by(plan, scene, views, time);
  EXPECT_EQ(culled.frame.masks, whole.frame.masks);
  EXPECT_EQ(whole.stats.shadow_rays, whole.stats.full_shadow_rays);
  const TraceStats& s = culled.stats;
  EXPECT_EQ(s.shadow_rays + s.turned_away + s.out_of_range + s.out_of_cone, s.full_shadow_rays);
  return s;
}

StereoView turned_eyes(const Scene& scene, double yaw_rad, std::uint32_t side) {
  const Rigid<Stage, Eye> camera = scene.camera.value();
  const auto eye = [&](double x) {
    return View{
        {glm::angleAxis(yaw_rad, glm::dvec3(0, 1, 0)) * camera.rotation, camera(Point<Eye>{{x, 0, 0}}).v},
        {-0.8, 0.8, 0.74, -0.85},
        {side, side}};
  };
  return {eye(-0.032), eye(0.032)};
}

TEST(TracerCulling, ChangesNoBitOfBoxOverPlane) {
  const Scene scene = load_scene(FARSHADE_ASSETS "/box_over_plane.gltf").value();
  for (const double yaw : {0.0, 0.4, -0.5}) expect_same_bits(scene, turned_eyes(scene, yaw, 256));
}

TEST(TracerCulling, ChangesNoBitOfTheRoom) {
  const Scene scene = load_scene(FARSHADE_ASSETS "/room.glb").value();
  for (int i = 0; i < 5; ++i) {
    SCOPED_TRACE(i);
    const TraceStats stats = expect_same_bits(scene, turned_eyes(scene, 1.3 * i, 256),
                                              time_from_ns(std::int64_t{i} * 1'300'000'000));
    EXPECT_GT(stats.turned_away, 0u);
  }
}

#ifdef FARSHADE_SHARED_SCENES
TEST(TracerCulling, ChangesNoBitOfTheSharedScenes) {
  for (const char* name : {"/modern_living_room.glb", "/pine_tree.glb"}) {
    SCOPED_TRACE(name);
    const Scene scene = load_scene(std::string(FARSHADE_SHARED_SCENES) + name).value();
    for (const double yaw : {0.0, 1.9, -2.2}) expect_same_bits(scene, turned_eyes(scene, yaw, 256));
  }
}
#endif

TEST(TracerCulling, ChangesNoBitOfRandomSoups) {
  const unsigned seed = 20261122;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uint64_t skipped = 0;
  for (int i = 0; i < (kSanitized ? 8 : 24); ++i) {
    SCOPED_TRACE(i);
    const Scene scene = random_soup(random);
    const double angle = 0.7 * i;
    const glm::dvec3 eye(2.5 * std::sin(angle), 0.3, 2.5 * std::cos(angle));
    const StereoView views{look(eye, {0.1, -0.8, 0}, 256),
                           look(eye + glm::dvec3(0, 0.06, 0), {0.1, -0.8, 0}, 256)};
    const TraceStats stats = expect_same_bits(scene, views, time_from_ns(std::int64_t{i} * 40'000'000));
    skipped += stats.full_shadow_rays - stats.shadow_rays;
  }
  EXPECT_GT(skipped, 0u);
}

const StereoView kInside{look({2, 1, 2}, {0, 0, 0}, 64), look({2, 1.1, 2}, {0, 0, 0}, 64)};

SceneBuilder hall() {
  SceneBuilder build;
  build.add(box({0, 0, 0}, {3, 2, 3}));
  build.point_light({0.3, 0.5, -0.2});
  return build;
}

TEST(TracerCulling, AMoverBetweenLightAndSurfaceCasts) {
  SceneBuilder build = hall();
  build.move(build.add(box({-2.5f, -1, -0.2f}, {0.25f, 0.25f, 0.25f})), {5, 0, 0});
  const Scene scene = build.build();
  Tracer tracer = Tracer::create(scene).value();
  ShadowFrame frame;
  for (const int ms : {0, 300, 560, 900, 0}) {
    SCOPED_TRACE(ms);
    const Time time = time_from_ns(std::int64_t{ms} * 1'000'000);
    tracer.trace(request_for(kInside, time), frame);
    TracePlan plan = needed_for(scene);
    plan.skips_rays = false;
    EXPECT_EQ(frame.masks, trace_by(plan, scene, kInside, time).frame.masks);
  }
}

/// A lampshade that stands on the floor and turns slowly around a fixed light. Its bounding box contains the
/// light and a part of the floor that the panels shadow.
TEST(TracerCulling, AMoverAroundAFixedLightCastsItsShadowInsideItsBox) {
  SceneBuilder build;
  build.add(quad({0, 0, 0}, {4, 0, 0}, {0, 0, -4}));
  NodeTransform placed;
  placed.translation = {0, 1, 0};
  build.turn(build.add(lampshade(0.6f, 1.01f), 0, placed), 0.5);
  build.point_light({0, 1, 0});
  const Scene scene = build.build();
  const StereoView views{look({0.1, 3.0, 2.9}, {0.03, 0.0, -0.1}, 256),
                         look({0.2, 3.0, 2.9}, {0.03, 0.0, -0.1}, 256)};
  for (const int ms : {0, 250, 900}) {
    SCOPED_TRACE(ms);
    const Time time = time_from_ns(std::int64_t{ms} * 1'000'000);
    expect_same_bits(scene, views, time);
    const oracle::Agreement agreement = expect_agrees(scene, views, time, 0.02);
    EXPECT_GT(agreement.lit * 10, agreement.pixel_lights);
  }
}

/// Two upright plates at the ends of a mover along each axis: its box is hollow, and a floor runs through it.
/// The lights see the box from all sides.
TEST(TracerCulling, AHollowMoverOfTwoPlatesCastsOnWhatIsInsideItsBox) {
  for (int axis = 0; axis < 3; ++axis) {
    SCOPED_TRACE(axis);
    glm::vec3 end(0.0f), u(0.0f), v(0.0f);
    end[axis] = 1, u[(axis + 1) % 3] = 1, v[(axis + 2) % 3] = 1;
    std::vector<glm::vec3> corners;
    for (const float side : {-1.0f, 1.0f}) {
      const Mesh plate = quad(end * side, u, v);
      corners.insert(corners.end(), plate.positions.begin(), plate.positions.end());
    }
    SceneBuilder build;
    build.add(quad({0, -0.3f, 0}, {2, 0, 0}, {0, 0, -2}));
    build.add(quad({-0.2f, 0, 0}, {0, 0, 2}, {0, 2, 0}));
    build.move(build.add(triangle_soup(corners)), {0.1, 0.05, 0.1});
    for (const double far : {-4.0, 4.0})
      for (int i = 0; i < 3; ++i) {
        glm::dvec3 at(0.35, 0.55, 0.45);
        at[i] = far;
        build.point_light(at);
        build.directional_light(-at);
      }
    const Scene scene = build.build();
    const StereoView views{look({0.7, 0.6, 0.65}, {0, -0.2, -0.1}, 192),
                           look({-0.7, 0.6, -0.6}, {0, -0.2, 0}, 192)};
    expect_same_bits(scene, views, time_from_ns(500'000'000));
  }
}

TEST(TracerCulling, ATurnedDirectionalLightCastsOtherShadows) {
  SceneBuilder build;
  build.add(quad({0, 0, 0}, {4, 0, 0}, {0, 0, -4}));
  build.add(box({0, 1, 0}, {0.5f, 0.5f, 0.5f}));
  build.directional_light({0.3, -1, 0.2});
  const Scene scene = build.build();
  Tracer tracer = Tracer::create(scene).value(), reference = Tracer::create_reference(scene).value();
  FrameRequest request = request_for({kLeftEye, kRightEye});
  change(request.lights, 0, true, LightPose{{}, {glm::normalize(glm::dvec3(-0.8, -1, 0.4))}});
  ShadowFrame frame, truth;
  tracer.trace(request, frame);
  reference.trace(request, truth);
  EXPECT_EQ(frame.masks, truth.masks);
}

/// A mover beyond the bounds of the fixed meshes.
TEST(TracerCulling, AMoverBesideTheFixedMeshesShadowsItself) {
  SceneBuilder build;
  build.add(quad({0, 0, 0}, {1, 0, 0}, {0, 0, -1}));
  std::vector<glm::vec3> corners;
  for (const float y : {0.5f, 1.0f}) {
    const Mesh plate = quad({2.5f, y, 0}, {1, 0, 0}, {0, 0, -1});
    corners.insert(corners.end(), plate.positions.begin(), plate.positions.end());
  }
  build.move(build.add(triangle_soup(corners)), {0.1, 0, 0});
  build.directional_light({0, -1, 0});
  const StereoView views{look({2.2, 0.8, 1.5}, {2.5, 0.4, 0}, 128),
                         look({2.3, 0.8, 1.5}, {2.5, 0.4, 0}, 128)};
  expect_same_bits(build.build(), views, time_from_ns(500'000'000));
}

TEST(TracerCulling, AReferenceTracesEveryRay) {
  const Scene scene = hall().build();
  for (const bool planned : {false, true}) {
    Tracer tracer =
        (planned ? Tracer::create_reference(scene, needed_for(scene)) : Tracer::create_reference(scene))
            .value();
    ShadowFrame frame;
    const TraceStats stats = tracer.trace(request_for(kInside), frame);
    EXPECT_GT(stats.shadow_rays, 0u);
    EXPECT_EQ(stats.shadow_rays, stats.full_shadow_rays);
    EXPECT_EQ(stats.turned_away + stats.out_of_range + stats.out_of_cone, 0u);
  }
}

TEST(TracerCulling, EverythingTracesEveryPixelAndLightAndAgreesWithTheOracle) {
  const Scene scene = load_scene(FARSHADE_ASSETS "/room.glb").value();
  const Time time = time_from_ns(1'300'000'000);
  const StereoView views = turned_eyes(scene, 0, kSanitized ? 48 : 96);
  const Traced all = trace_by(everything_for(scene), scene, views, time);
  EXPECT_EQ(all.stats.shadow_rays, all.stats.full_shadow_rays);
  for (const Side side : kSides) {
    const auto truth = oracle::trace(scene, state_at(scene, time), views[index_of(side)]);
    const oracle::Agreement agreement = oracle::compare(all.frame.masks[index_of(side)], truth);
    EXPECT_EQ(agreement.wrong, 0u) << agreement.wrong_x << ", " << agreement.wrong_y;
    EXPECT_GT(agreement.lit, 0u);
  }
}

TEST(TracerMemory, IsByUse) {
  const Scene scene = hall().build();
  const TracerMemory needed = Tracer::create(scene).value().memory();
  EXPECT_EQ(needed.vertices, (36 + 1 + 36) * sizeof(glm::vec3));
  EXPECT_EQ(needed.triangles, 12 * sizeof(glm::uvec3));
  EXPECT_GT(needed.facets, 0u);
  EXPECT_GT(needed.hierarchy, 0u);
  EXPECT_GE(needed.hierarchy_peak, needed.hierarchy);
  const TracerMemory everything = Tracer::create(scene, everything_for(scene)).value().memory();
  EXPECT_GT(everything.hierarchy, needed.hierarchy);
}

TEST(TracerCulling, EverythingTracesBothOfCoincidingViews) {
  SceneBuilder build;
  build.add(quad({0, 0, 0}, {4, 0, 0}, {0, 0, -4}));
  build.point_light({0, 2, 0});
  const Scene scene = build.build();
  EXPECT_EQ(trace_by(everything_for(scene), scene, {kLeftEye, kLeftEye}).stats.primary_rays, 2u * 64 * 64);
  EXPECT_EQ(trace_by(needed_for(scene), scene, {kLeftEye, kLeftEye}).stats.primary_rays, 64u * 64);
}

}  // namespace
}  // namespace farshade
