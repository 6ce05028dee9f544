// Tracing from received positions, compared with the ordinary trace where a difference would be visible, and
// with results on paper.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "stereo/gltf/gltf.h"
#include "stereo/tracer/placed_surface.h"
#include "tests/oracle/agreement.h"
#include "tests/oracle/scene_builder.h"
#include "tests/oracle/surfaces.h"

namespace farshade {
namespace {

const View kFromAbove = look({0.13, 3.0, 2.9}, {0.03, 0.0, -0.1}, 128);

PositionGrid grid_over(const Scene& scene, std::uint32_t bits) {
  return grid_of({scene.bounds.low}, {scene.bounds.high}, bits);
}

/// The values that a rasteriser computes at the pixel centres of a view.
struct Rasterised {
  std::vector<float> distance_m;
  std::vector<glm::dvec3> position, normal;  ///< stage; the shading normal, on the viewer's side
};

Rasterised seen(const Scene& scene, const View& view) {
  const oracle::Surfaces surfaces(scene, state_at(scene, Time{}), oracle::Search::Tree);
  const FovTangents window = tangents_of(view.fov);
  Rasterised result;
  for (std::uint32_t y = 0; y < view.size.height; ++y)
    for (std::uint32_t x = 0; x < view.size.width; ++x) {
      const Vector<Eye> ray{pixel_ray(window, view.size, {x + 0.5, y + 0.5})};
      const oracle::Ray stage_ray{view.stage_from_eye.translation, view.stage_from_eye(ray).v};
      const auto hit = surfaces.nearest(stage_ray);
      result.distance_m.push_back(hit ? static_cast<float>(hit->t) : 0.0f);
      result.position.push_back(stage_ray.origin + stage_ray.direction * (hit ? hit->t : 0.0));
      glm::dvec3 normal(0.0);
      if (hit) {
        const auto& n = hit->triangle->normal;
        normal = n[0] * (1 - hit->u - hit->v) + n[1] * hit->u + n[2] * hit->v;
        if (glm::dot(hit->triangle->facing, stage_ray.direction) > 0) normal = -normal;
      }
      result.normal.push_back(normal);
    }
  return result;
}

glm::dvec3 way_to(const Light& light, const glm::dvec3& from) {
  return light.kind == LightKind::Directional ? -light.direction.v : light.position.v - from;
}

struct Placed {
  PerEye<PositionPlanes> planes;
  PositionGrid grid;
};

Placed placed(const Scene& scene, const View& view, const Rasterised& seen, std::uint32_t bits) {
  Placed result{.planes = {}, .grid = grid_over(scene, bits)};
  for (PositionPlanes& planes : result.planes) positions_of(view, seen.distance_m, result.grid, planes);
  return result;
}

ShadowFrame traced(const Scene& scene, const View& view, const Placed& from) {
  auto tracer = Tracer::create(scene).value();
  ShadowFrame frame;
  tracer.trace(request_for({view, view}), from.planes, from.grid, frame);
  EXPECT_EQ(frame.masks[0], frame.masks[1]);
  return frame;
}

/// The share of wrong bits (compared with the ordinary trace) among pixel-lights that face each other.
double wrong_share(const Scene& scene, const View& view, const Rasterised& seen, const EyeMask& mask) {
  const EyeMask truth = reference_traced(scene, {view, view}).masks[0];
  const SceneState state = state_at(scene, Time{});
  std::uint64_t facing = 0, wrong = 0;
  for (std::uint32_t i = 0; i < view.size.pixels(); ++i)
    for (std::uint32_t light = 0; light < mask.lights() && seen.distance_m[i] > 0; ++light) {
      if (glm::dot(seen.normal[i], way_to(state.light_set.lights[light], seen.position[i])) <= 0) continue;
      const std::uint32_t x = i % view.size.width, y = i / view.size.width;
      ++facing, wrong += mask.lit(x, y, light) != truth.lit(x, y, light);
    }
  EXPECT_GT(facing, 1000u);
  return static_cast<double>(wrong) / static_cast<double>(facing);
}

Scene bundled(const char* name) {
  return load_scene(std::string(FARSHADE_ASSETS) + "/" + name).value();
}

View camera_of(const Scene& scene, std::uint32_t side_px) {
  return {scene.camera.value_or(Rigid<Stage, Eye>{}), {-0.8, 0.8, 0.8, -0.8}, {side_px, side_px}};
}

/// With 24 bits, the precision of float, the bits equal those of the ordinary trace except at edges.
TEST(PositionTrace, AgreesWithTheOrdinaryTraceAt24Bits) {
  for (const char* name : {"room.glb", "box_over_plane.gltf"}) {
    const Scene scene = bundled(name);
    const View view = camera_of(scene, 192);
    const Rasterised what = seen(scene, view);
    const ShadowFrame frame = traced(scene, view, placed(scene, view, what, 24));
    EXPECT_LT(wrong_share(scene, view, what, frame.masks[0]), 0.0005) << name;
  }
}

TEST(PositionTrace, IsLessRightTheFewerBits) {
  const Scene scene = bundled("room.glb");
  const View view = camera_of(scene, 192);
  const Rasterised what = seen(scene, view);
  double before = 1;
  for (const std::uint32_t bits : {8u, 10u, 12u, 14u, 16u}) {
    const ShadowFrame frame = traced(scene, view, placed(scene, view, what, bits));
    const double wrong = wrong_share(scene, view, what, frame.masks[0]);
    std::printf("room.glb, %u bits: %.4f %% of the facing pixel-lights are wrong\n", bits, 100 * wrong);
    EXPECT_LT(wrong, before) << bits;
    before = wrong;
  }
  EXPECT_LT(before, 0.002);
}

/// A floor does not shadow itself, at any grid size and any angle of the light.
TEST(PositionTrace, LeavesAPlaneInTheLight) {
  for (const double height : {2.0, 0.05})
    for (const std::uint32_t bits : {8u, 10u, 12u, 16u, 24u}) {
      SceneBuilder build;
      build.add(quad({0, 0.013f, 0}, {4, 0.3f, 0.1f}, {0.1f, 0.2f, -4}));
      build.point_light({-6.0, height - 0.4, 0.3});
      const Scene scene = build.build();
      const Rasterised what = seen(scene, kFromAbove);
      const ShadowFrame frame = traced(scene, kFromAbove, placed(scene, kFromAbove, what, bits));
      EXPECT_EQ(wrong_share(scene, kFromAbove, what, frame.masks[0]), 0.0) << bits << " bits, " << height;
    }
}

/// Rays of a surface that is nearer to the eye than the grid's error start between them. A plate behind the
/// eye does not hide the light before the plate.
TEST(PositionTrace, StartsNoRayBehindTheEye) {
  SceneBuilder build;
  build.add(quad({0, 0, 0}, {4, 0, 0}, {0, 0, -4}));
  build.add(quad({0, 0.015f, 0}, {1, 0, 0}, {0, 0, -1}));
  build.point_light({0.3, 0.012, 0.1});
  const Scene scene = build.build();
  const View view = look({0.13, 0.01, 0.1}, {0.13, 0, 0.1}, 128);
  const Rasterised what = seen(scene, view);
  const Placed from = placed(scene, view, what, 8);
  ASSERT_GT(from.grid.step_m, 0.03);
  EXPECT_EQ(wrong_share(scene, view, what, traced(scene, view, from).masks[0]), 0.0);
}

/// A wall that covers one half of the view, and a wall far behind it. At the edge, one neighbour of a pixel
/// lies in its own wall and the other one in the other wall.
TEST(PlacedSurface, LiftsRaysAtAnEdgeAsFarAsBesideIt) {
  const View view = look({0, 0, 0}, {0, 0, -1}, kTileSide_px, 0.9);
  for (const glm::vec3& side : {glm::vec3(-3, 0, 0), {3, 0, 0}, {0, -3, 0}, {0, 3, 0}}) {
    SCOPED_TRACE(testing::Message() << side.x << ", " << side.y);
    SceneBuilder build;
    build.add(quad(side + glm::vec3(0, 0, -2), {3, 0, 0}, {0, 3, 0}));
    build.add(quad({0, 0, -6}, {6, 0, 0}, {0, 6, 0}));
    const Scene scene = build.build();
    const Rasterised what = seen(scene, view);
    const Placed from = placed(scene, view, what, 24);
    const Rigid<Anchor, Stage> unmoved{};
    const PlacedEye eye{from.planes[0], unmoved(from.grid.low), from.grid.step_m, rays_of(view, unmoved), 6};
    PlacedSurface surface;
    place_tile(eye, {0, 0, kTileSide_px, kTileSide_px}, surface);
    ASSERT_EQ(surface.covered, view.size.pixels());
    const double offset = double{kOffset} * eye.reach;
    for (int i = 0; i < kTilePixels; ++i) {
      const TilePixel pixel = kTileOrder[static_cast<std::size_t>(i)];
      const double wall = what.position[pixel.y * kTileSide_px + pixel.x].z;
      EXPECT_GT(surface.oz[i] - wall, 0.9 * offset) << i;
      EXPECT_LT(surface.oz[i] - wall, 1.5 * offset) << i;
    }
  }
}

/// A wall that covers one half of the view, and a wall behind it. Their rounded positions may belong to one
/// plane up to a step of four times E (placed_surface.h), or 3.5 steps of the grid.
TEST(PlacedSurface, IsSureOfANormalExceptBesideAnEdgeOrALargeStep) {
  const double step = grid_of({{-3, -3, 0}}, {{3, 3, 0}}, 10).step_m;
  const View view = look({0, 0, 3}, {0, 0, 0}, 3 * kTileSide_px, 0.9);
  for (const auto& [behind, is_edge] : {std::pair(6.0, true), {5 * step, true}, {3 * step, false}}) {
    SCOPED_TRACE(behind);
    SceneBuilder build;
    build.add(quad({-1.5, 0, 0}, {1.5, 0, 0}, {0, 3, 0}));
    build.add(quad({0, 0, -behind}, {3, 0, 0}, {0, 3, 0}));
    const Scene scene = build.build();
    const Placed from = placed(scene, view, seen(scene, view), 10);
    const Rigid<Anchor, Stage> unmoved{};
    const PlacedEye eye{from.planes[0], unmoved(from.grid.low), from.grid.step_m, rays_of(view, unmoved), 6};
    PlacedSurface surface;
    place_tile(eye, {kTileSide_px, kTileSide_px, 2 * kTileSide_px, 2 * kTileSide_px}, surface);
    for (int i = 0; i < kTilePixels; ++i) {
      const std::uint32_t x = kTileOrder[static_cast<std::size_t>(i)].x;
      const bool is_beside = x == kTileSide_px / 2 - 1 || x == kTileSide_px / 2;
      EXPECT_EQ(surface.tilt[i] < 1, !(is_edge && is_beside)) << i;
    }
  }
}

/// A box over a floor: its shadow on paper. Bits within `off` m of the shadow's edge are not tested.
TEST(PositionTrace, MatchesPaperAnswerForBoxOverPlane) {
  SceneBuilder build;
  build.add(quad({0, 0, 0}, {4, 0, 0}, {0, 0, -4}));
  build.add(box({0.2f, 1, -0.3f}, {0.5f, 0.25f, 0.4f}));
  build.point_light({0.2, 3, -0.3});
  const Scene scene = build.build();
  const Rasterised what = seen(scene, kFromAbove);
  for (const std::uint32_t bits : {12u, 16u, 24u}) {
    const Placed from = placed(scene, kFromAbove, what, bits);
    const EyeMask mask = traced(scene, kFromAbove, from).masks[0];
    // The light is at 3 m and the box's top at 1.25 m, so the shadow's half sides are 3 / 1.75 times the
    // box's. A ray that starts up to 2 E before the floor moves the shadow by up to 6 E: rays have a slope of
    // at most 2 to 1 here.
    const double off = 6 * std::sqrt(3.0) / 2 * from.grid.step_m + 1e-4;
    const double half_x = 0.5 * 3 / 1.75, half_z = 0.4 * 3 / 1.75;
    std::uint32_t dark = 0, bright = 0;
    for (std::uint32_t i = 0; i < kFromAbove.size.pixels(); ++i) {
      const glm::dvec3& p = what.position[i];
      if (what.distance_m[i] == 0 || std::abs(p.y) > 1e-6) continue;
      const double inside = std::min(half_x - std::abs(p.x - 0.2), half_z - std::abs(p.z + 0.3));
      if (std::abs(inside) < off) continue;
      const bool lit = mask.lit(i % 128, i / 128, 0);
      ASSERT_EQ(lit, inside < 0) << bits << " bits, at " << p.x << ", " << p.z;
      (lit ? bright : dark) += 1;
    }
    EXPECT_GT(dark, 200u);
    EXPECT_GT(bright, 1000u);
  }
}

TEST(PositionTrace, KeepsToRangesConesAndSwitchedOffLights) {
  SceneBuilder build;
  build.add(quad({0, 0, 0}, {4, 0, 0}, {0, 0, -4}));
  build.point_light({0.5, 2, 0.2}, 2.5f);
  build.spot_light({-0.5, 2, 0}, {0.1, -1, 0.1}, 0.5f);
  build.directional_light({0.3, -1, 0.2});
  build.point_light({0, 2, 0});
  const Scene scene = build.build();
  const Rasterised what = seen(scene, kFromAbove);
  const Placed from = placed(scene, kFromAbove, what, 24);
  auto tracer = Tracer::create(scene).value();
  FrameRequest request = request_for({kFromAbove, kFromAbove});
  const ShadowFrame first = [&] {
    ShadowFrame frame;
    tracer.trace(request, frame);
    return frame;
  }();
  request.lights = {.revision = {2}, .lights = {{.light = 3, .revision = {2}, .on = false, .pose = {}}}};
  ShadowFrame frame, truth;
  const TraceStats stats = tracer.trace(request, from.planes, from.grid, frame);
  tracer.trace(request, truth);
  EXPECT_EQ(frame.light_set_revision, LightSetRevision{2});
  EXPECT_NE(truth.masks[0], first.masks[0]);
  EXPECT_EQ(stats.primary_rays, 0u);
  EXPECT_GT(stats.out_of_range, 0u);
  EXPECT_GT(stats.out_of_cone, 0u);
  std::uint32_t differ = 0;
  for (std::uint32_t i = 0; i < kFromAbove.size.pixels(); ++i)
    differ += frame.masks[0].word(i % 128, i / 128) != truth.masks[0].word(i % 128, i / 128);
  EXPECT_LT(differ, kFromAbove.size.pixels() / 500);
}

/// Pixels that are turned away from a light need no ray. Tiles that were not received cover nothing.
TEST(PositionTrace, SparesRaysOfWhatIsTurnedAwayOrMissing) {
  SceneBuilder build;
  build.add(quad({0, 0, 0}, {4, 0, 0}, {0, 0, -4}));
  build.point_light({0.5, -2, 0.2});
  const Scene below = build.build();
  const Rasterised what = seen(below, kFromAbove);
  Placed from = placed(below, kFromAbove, what, 16);
  auto tracer = Tracer::create(below).value();
  ShadowFrame frame;
  const TraceStats stats = tracer.trace(request_for({kFromAbove, kFromAbove}), from.planes, from.grid, frame);
  EXPECT_GT(stats.turned_away, stats.full_shadow_rays * 95 / 100);

  build.point_light({0.5, 2, 0.2});
  const Scene both = build.build();
  const ShadowFrame whole = traced(both, kFromAbove, from);
  for (PositionPlanes& planes : from.planes)
    for (PixelPlane& plane : planes)
      for (std::uint32_t i = 0; i < plane.words.size(); ++i)
        if (i / 128 / 16 == 4 && i % 128 / 16 == 3) plane.words[i] = 0;
  const ShadowFrame lossy = traced(both, kFromAbove, from);
  for (std::uint32_t y = 0; y < 128; ++y)
    for (std::uint32_t x = 0; x < 128; ++x)
      ASSERT_EQ(lossy.masks[0].word(x, y), y / 16 == 4 && x / 16 == 3 ? 0 : whole.masks[0].word(x, y));
}

TEST(PositionTrace, IsAsGoodFarFromTheOrigin) {
  SceneBuilder build({1e6, -1e6, 1e6});
  build.add(quad({0, 0, 0}, {4, 0, 0}, {0, 0, -4}));
  build.add(box({0, 1, 0}, {0.5f, 0.5f, 0.5f}));
  build.point_light({-2.0, 2.5, -0.4});
  const Scene scene = build.build();
  View view = kFromAbove;
  view.stage_from_eye.translation += glm::dvec3{1e6, -1e6, 1e6};
  const Rasterised what = seen(scene, view);
  const ShadowFrame frame = traced(scene, view, placed(scene, view, what, 24));
  EXPECT_LT(wrong_share(scene, view, what, frame.masks[0]), 0.002);
}

}  // namespace
}  // namespace farshade
