// A moving mesh in a light's map: no point of its bounding box, and no point behind the box, may be proved
// lit.
#include "stereo/tracer/light_visibility_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "stereo/tracer/light_proof.h"
#include "tests/oracle/scene_builder.h"
#include "tests/unit/tracer/cell_place.h"

namespace farshade {
namespace {

/// Whether the map has a cell for the point. A directional light's map ends with the fixed meshes.
bool is_in_frame(const CellFrame& frame, Point<Anchor> p) {
  if (frame.cube) return true;
  const double half = frame.side * 0.5;
  const glm::dvec3 v = (p - frame.origin).v;
  return std::abs(glm::dot(frame.rows[0], v)) < half && std::abs(glm::dot(frame.rows[1], v)) < half;
}

/// A rotated, scaled and mirrored box that moves in a hall.
Scene mover_scene(std::mt19937& random, LightKind kind) {
  std::uniform_real_distribution<double> place(-1, 1), size(0.05, 1.5);
  SceneBuilder build;
  build.add(box({0, 0, 0}, {4, 4, 4}));
  NodeTransform transform;
  transform.translation = {place(random), place(random), place(random)};
  transform.rotation = toward({place(random), place(random), place(random)});
  transform.scale = {size(random), -size(random), size(random)};
  const Mesh mesh = box({0.3f, -0.2f, 0.1f}, {0.5f, 0.15f, 1.1f});
  build.move(build.add(mesh, 0, transform), {0.1, -0.1, 0.2});
  const glm::dvec3 around(place(random), place(random), place(random));
  const bool inside = place(random) < 0;
  if (kind == LightKind::Directional)
    build.directional_light(around);
  else if (inside)
    build.point_light(transform.translation +
                      transform.rotation * (transform.scale * (glm::dvec3(0.3, -0.2, 0.1) +
                                                               glm::dvec3(0.45, 0.13, 1) * around)));
  else
    build.point_light(transform.translation + 1.2 * around);
  return build.build();
}

void expect_no_point_of_the_mover_proved_lit(LightKind kind, unsigned seed) {
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-1, 1);
  int inside = 0;
  for (int i = 0; i < 60; ++i) {
    const Scene scene = mover_scene(random, kind);
    const SceneState start = state_at(scene, Time{}), now = state_at(scene, time_from_ns(400'000'000));
    SurfaceModel model(scene, start, plan_for(scene, {.all_lights = true}).trace);
    const ShadowLight light = shadow_light(now.light_set.lights[0], model);
    LightVisibilityMap map(light, planes_of(model), model);
    model.place(now);
    map.place(model);
    const Patch& mover = model.patches()[model.fixed_count()];
    const glm::dmat4& stage_from_object = now.stage_from_object[mover.instance].matrix;
    const glm::dvec3 light_in_box =
        glm::dvec3(glm::inverse(stage_from_object) * glm::dvec4(now.light_set.lights[0].position.v, 1)) -
        mover.object_center.v;
    inside += glm::all(glm::lessThan(glm::abs(light_in_box), mover.object_half));
    for (int sample = 0; sample < 2000; ++sample) {
      glm::dvec3 in_box(place(random), place(random), place(random));
      if (sample % 2 == 0) in_box[sample / 2 % 3] = sample / 6 % 2 == 0 ? -1 : 1;  // on its surface
      const glm::dvec3 object = mover.object_center.v + in_box * mover.object_half;
      const Point<Anchor> p =
          model.anchor_from_stage()(Point<Stage>{glm::dvec3(stage_from_object * glm::dvec4(object, 1))});
      if (!is_in_frame(map.frame(), p)) continue;
      const CellTouch truth = place_of(map.frame(), p);
      ASSERT_LE(map.cells()[truth.cell].moving, truth.depth) << "scene " << i << ", sample " << sample;
    }
  }
  if (kind != LightKind::Directional) {
    EXPECT_GT(inside, 10) << "lights inside the mover";
  }
}

TEST(LightVisibilityMap, ProvesNoPointOfAMoverLitByAPointLight) {
  expect_no_point_of_the_mover_proved_lit(LightKind::Point, 20261124);
}

TEST(LightVisibilityMap, ProvesNoPointOfAMoverLitByADirectionalLight) {
  expect_no_point_of_the_mover_proved_lit(LightKind::Directional, 20261125);
}

/// A mover 1 km from the anchor, while the fixed meshes surround the anchor. Starts of rays lie before its
/// face, nearer to the light than 24 u M, by which rounding may move ray and face together, and farther.
TEST(LightProof, AllowsForTheRoundingOfAFarMover) {
  SceneBuilder build;
  for (const float x : {-0.5f, 0.5f}) build.add(box({x, 0, 0}, {0.25f, 0.25f, 0.25f}));
  const std::uint32_t mover = build.add(box({1000, 0, 0}, {0.5f, 0.5f, 0.5f}));
  build.move(mover, {0.1, 0, 0});
  build.point_light({1000, 1.5, 0});
  const Scene scene = build.build();
  const SceneState state = state_at(scene, Time{});
  const SurfaceModel model(scene, state, plan_for(scene, {.all_lights = true}).trace);
  const FacetPlanes planes = planes_of(model);
  const ShadowLight light = shadow_light(state.light_set.lights[0], model);
  ASSERT_LT(planes.reach, 10) << "the anchor is among the fixed meshes";
  const LightVisibilityMap map(light, planes, model);
  const float reach = model.patches()[model.fixed_count()].placement.reach + light.reach;
  for (const float before : {24.0f, 64.0f}) {
    TileSurface surface{};
    for (int i = 0; i < 4; ++i) {
      const double aside = 0.1 * i - 0.15, above = 0.5 + double{before / (1 << 24) * reach};
      const Point<Stage> start{{1000 + aside, above, 0.3 * aside}};
      const glm::vec3 in_anchor(model.anchor_from_stage()(start).v);
      surface.ox[i] = in_anchor.x, surface.oy[i] = in_anchor.y, surface.oz[i] = in_anchor.z;
      surface.reach[i] = reach;
    }
    Ints<4> lanes = ~Ints<4>{}, proven{};
    prove<4>(map, surface, 0, lanes, proven);
    EXPECT_EQ(counted(proven), before < 32 ? 0u : 4u) << before;
  }
}

/// A tilted floor of many quads: most of its triangles share planes.
Scene tilted_floor() {
  SceneBuilder build;
  for (int x = -4; x < 4; ++x)
    for (int z = -4; z < 4; ++z)
      build.add(quad({static_cast<float>(x), 0.07f * static_cast<float>(x) + 0.013f, static_cast<float>(z)},
                     {0.5f, 0.035f, 0}, {0, 0, -0.5f}));
  build.point_light({0.3, 2, 0.1});
  return build.build();
}

TEST(FacetPlanes, ContainTheirTrianglesAndAllowForTheTraversalsRounding) {
  const Scene scene = tilted_floor();
  const SurfaceModel model(scene, state_at(scene, Time{}), plan_for(scene, {.all_lights = true}).trace);
  const FacetPlanes planes = planes_of(model);
  EXPECT_LT(planes.planes.size(), planes.of_triangle.size());
  for (std::size_t t = 0; t < planes.of_triangle.size(); ++t) {
    const FacetPlane& plane = planes.planes.at(planes.of_triangle[t]);
    EXPECT_GE(plane.doubt, 24.0f / (1 << 24) * plane.reach) << "what the traversal may lose at a plane";
    for (int corner = 0; corner < 3; ++corner) {
      const glm::vec3 p = model.positions()[model.triangles()[t][corner]];
      const double along = glm::dot(glm::dvec3(plane.normal), glm::dvec3(p));
      EXPECT_GE(along, plane.low);
      EXPECT_LE(along, plane.high);
    }
  }
}

/// A triangle 100 times as long as high: 24 u M for the traversal, 8 u M for the plane's arithmetic, and
/// 2 u M for each multiple above 8.
TEST(FacetPlanes, AllowMoreForThinTriangles) {
  SceneBuilder build;
  build.add(triangle_soup({{-50, 0, 0}, {50, 0, 0}, {0, 0, -1}}));
  const Scene scene = build.build();
  const SurfaceModel model(scene, state_at(scene, Time{}), plan_for(scene, {.all_lights = true}).trace);
  const FacetPlane plane = planes_of(model).planes.at(0);
  EXPECT_NEAR(plane.doubt * (1 << 24) / plane.reach, 24 + 8 + 2 * (100 - 8), 1);
}

/// Starts of shadow rays at 0.3 and 20 times the plane's tolerance above the floor.
TEST(LightProof, NeedsMoreThanThePlanesToleranceAboveIt) {
  const Scene scene = tilted_floor();
  const SceneState state = state_at(scene, Time{});
  const SurfaceModel model(scene, state, plan_for(scene, {.all_lights = true}).trace);
  const LightVisibilityMap map(shadow_light(state.light_set.lights[0], model), planes_of(model), model);
  const LightVisibilityMap::Plane& plane = map.planes()[map.cells()[place_of(map.frame(), {}).cell].plane[0]];
  const glm::vec3 normal(plane.nx, plane.ny, plane.nz);
  // The tolerance of a ray is that of the plane, or four times as much.
  for (const auto& [own, height] : {std::pair(1.0f, 0.3f), {1.0f, 20.0f}, {4.0f, 3.0f}, {4.0f, 6.0f}}) {
    TileSurface surface{};
    for (int i = 0; i < 4; ++i) {
      const glm::vec3 aside(0.3f * static_cast<float>(i) - 0.5f, 0, 0.21f * static_cast<float>(i));
      const glm::vec3 on_plane = aside + normal * (plane.offset - glm::dot(normal, aside));
      const glm::vec3 start = on_plane + normal * (height * plane.doubt);
      surface.ox[i] = start.x, surface.oy[i] = start.y, surface.oz[i] = start.z;
      surface.reach[i] = own * plane.doubt / (0.5f * kOffset);
    }
    Ints<4> lanes = ~Ints<4>{}, proven{};
    prove<4>(map, surface, 0, lanes, proven);
    EXPECT_EQ(counted(proven), height < own ? 0u : 4u) << own << ", " << height;
  }
}

}  // namespace
}  // namespace farshade
