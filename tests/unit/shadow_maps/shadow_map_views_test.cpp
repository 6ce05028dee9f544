#include "stereo/shadow_maps/shadow_map_views.h"

#include <gtest/gtest.h>

#include <random>

namespace farshade {
namespace {

constexpr ShadowMapSettings kWish{.side_px = 256, .pcf_radius = 2};
constexpr double kGuard = 3;  ///< border around the part that a map must contain, texels
constexpr int kCases = 500;

/// Random lights, boxes and points, `GetParam()` metres from the stage's origin.
class ShadowMapViewsOf : public testing::TestWithParam<double> {
 protected:
  double between(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }
  glm::dvec3 in_cube(double half) {
    return {between(-half, half), between(-half, half), between(-half, half)};
  }
  Light light(LightKind kind) {
    return {.kind = kind,
            .position = {far_ + in_cube(1)},
            .direction = {glm::normalize(in_cube(1))},
            .outer_cone_rad = 0.5f};
  }
  std::vector<Point<Stage>> corners() {
    std::vector<Point<Stage>> result;
    for (int i = 0; i < 16; ++i) result.push_back({far_ + in_cube(5)});
    return result;
  }

  const glm::dvec3 far_ = glm::dvec3(0.6, -0.64, 0.48) * GetParam();
  std::mt19937_64 random_{31};  // the seed
};

/// Texel position and depth. Empty for a point behind the view.
std::optional<glm::dvec3> seen(const glm::dmat4& clip_from_stage, Point<Stage> p) {
  const glm::dvec4 clip = clip_from_stage * glm::dvec4(p.v, 1.0);
  if (clip.w <= 0) return std::nullopt;
  return glm::dvec3((glm::dvec2(clip) / clip.w * 0.5 + 0.5) * double{kWish.side_px}, clip.z / clip.w);
}

bool within(const glm::dvec3& texel, double guard) {
  return texel.x >= guard && texel.y >= guard && texel.x <= kWish.side_px - guard &&
         texel.y <= kWish.side_px - guard;
}

TEST_P(ShadowMapViewsOf, ACubeSeesEveryDirectionWithOneFaceThatTheAxisNames) {
  for (int i = 0; i < kCases; ++i) {
    const Light point = light(LightKind::Point);
    const ShadowMapViews views = shadow_map_views({&point, 1}, corners(), kWish);
    ASSERT_EQ(views.layer_clip.size(), 6u);
    const glm::dvec3 away = in_cube(4), size = glm::abs(away);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const std::size_t face = static_cast<std::size_t>(2 * axis) + (away[axis] < 0 ? 1 : 0);
    const auto texel = seen(views.layer_clip[face], {point.position.v + away});
    ASSERT_TRUE(texel);
    EXPECT_TRUE(within(*texel, kGuard - 1e-6)) << texel->x << ' ' << texel->y;
    EXPECT_NEAR(texel->z * size[axis], kNearPlane_m, 1e-9);
  }
}

TEST_P(ShadowMapViewsOf, AWindowHoldsItsCone) {
  for (int i = 0; i < kCases; ++i) {
    const Light spot = light(LightKind::Spot);
    const ShadowMapViews views = shadow_map_views({&spot, 1}, corners(), kWish);
    ASSERT_EQ(views.layer_clip.size(), 1u);
    const glm::dvec3 aside = glm::normalize(glm::cross(spot.direction.v, in_cube(1)));
    const glm::dvec3 rim = spot.direction.v + std::tan(0.5) * aside;
    const auto texel = seen(views.layer_clip[0], {spot.position.v + rim * between(0.1, 50)});
    ASSERT_TRUE(texel);
    EXPECT_TRUE(within(*texel, kGuard - 1e-3));
    EXPECT_NEAR(glm::length(glm::dvec2(*texel) - 0.5 * kWish.side_px), 0.5 * kWish.side_px - kGuard, 1e-3);
  }
}

TEST_P(ShadowMapViewsOf, AParallelViewHoldsTheSceneAndWhatIsNearerIsDeeper) {
  for (int i = 0; i < kCases; ++i) {
    const Light sun = light(LightKind::Directional);
    const std::vector<Point<Stage>> all = corners();
    const ShadowMapViews views = shadow_map_views({&sun, 1}, all, kWish);
    for (const Point<Stage>& corner : all) {
      const auto texel = seen(views.layer_clip[0], corner);
      ASSERT_TRUE(texel);
      EXPECT_TRUE(within(*texel, kGuard));
      EXPECT_GT(texel->z, 0);
      EXPECT_LT(texel->z, 1);
      EXPECT_GT(seen(views.layer_clip[0], {corner.v - sun.direction.v * 0.001})->z, texel->z);
    }
  }
}

/// The texel position and depth of a point as shadow_lookup.glsl computes them.
glm::vec3 looked_up(const gpu::ShadowMapData& map, const glm::vec3& from_eye) {
  const glm::vec3 d = from_eye - glm::vec3(map.origin[1]);
  const glm::vec3 p(glm::dot(d, glm::vec3(map.right)), glm::dot(d, glm::vec3(map.up)),
                    glm::dot(d, glm::vec3(map.ahead)));
  const bool parallel = map.place.x == FARSHADE_MAP_PARALLEL;
  const glm::vec2 at = glm::vec2(p) / (parallel ? 1.0f : p.z) * glm::vec2(map.right.w, -map.up.w);
  return {at + 0.5f * static_cast<float>(kWish.side_px),
          parallel ? -p.z * map.ahead.w : static_cast<float>(kNearPlane_m) / p.z};
}

TEST_P(ShadowMapViewsOf, ShadersFindPointsWhereTheyWereDrawn) {
  StereoView shown;
  for (int i = 0; i < kCases; ++i) {
    shown[1].stage_from_eye.translation = far_ + in_cube(3);
    const Light given = light(i % 2 == 0 ? LightKind::Spot : LightKind::Directional);
    const ShadowMapViews views = shadow_map_views({&given, 1}, corners(), kWish);
    const glm::dvec3 p = given.position.v + given.direction.v * between(1, 9) + in_cube(0.4);
    const auto drawn = seen(views.layer_clip[0], {p});
    ASSERT_TRUE(drawn);
    const gpu::ShadowMapData data = shadow_map_data(shown, views.lights[0]);
    const glm::vec3 found = looked_up(data, glm::vec3(p - shown[1].stage_from_eye.translation));
    EXPECT_NEAR(found.x, drawn->x, 1e-3);
    EXPECT_NEAR(found.y, drawn->y, 1e-3);
    EXPECT_NEAR(found.z, drawn->z, 1e-5 * (i % 2 == 0 ? drawn->z : 1.0));
  }
}

INSTANTIATE_TEST_SUITE_P(FromOrigin, ShadowMapViewsOf, testing::Values(0.0, 1e6));

TEST(ShadowMapViews, LightsFollowEachOtherAndThoseThatAreOffSeeNothing) {
  const auto light = [](LightKind kind, float cone_rad, bool on) {
    return Light{
        .kind = kind, .on = on, .position = {}, .direction = {{0, -1, 0}}, .outer_cone_rad = cone_rad};
  };
  const std::vector<Light> lights{light(LightKind::Point, 0, false), light(LightKind::Spot, 0.4f, true),
                                  light(LightKind::Spot, 1.2f, true), light(LightKind::Directional, 0, true)};
  const std::vector<Point<Stage>> corners{{{-1, -1, -1}}, {{1, 1, 1}}};
  const ShadowMapViews views = shadow_map_views(lights, corners, kWish);
  EXPECT_EQ(views.lights[1].first_layer, 6u);
  EXPECT_EQ(views.lights[2].first_layer, 7u);
  EXPECT_EQ(views.lights[3].first_layer, 13u);
  EXPECT_EQ(views.layer_clip.size(), 14u);
  EXPECT_EQ(views.lights[0].view.kind, FARSHADE_MAP_NONE);
  EXPECT_EQ(views.lights[2].view.kind, FARSHADE_MAP_CUBE) << "too wide for one perspective projection";
  for (int layer = 0; layer < 6; ++layer) EXPECT_FALSE(seen(views.layer_clip[0], {{0, 0, -3}}));
}

Scene with_point_lights(std::size_t count) {
  Scene scene;
  scene.nodes.resize(1);
  scene.lights.assign(count, LightSource{});
  return scene;
}

TEST(ShadowMapBytes, AreThoseOfEveryFaceAndRefusedBeyondTheBudget) {
  EXPECT_EQ(shadow_map_bytes(with_point_lights(3), {.side_px = 1024}).value(), 18ull << 22);
  const Expected<std::uint64_t> many = shadow_map_bytes(with_point_lights(256), {.side_px = 1024});
  ASSERT_FALSE(many);
  EXPECT_EQ(many.error().fault, Fault::Unavailable);
  EXPECT_NE(many.error().what.find("256 texels would do"), std::string::npos) << many.error().what;
  EXPECT_TRUE(shadow_map_bytes(with_point_lights(256), {.side_px = 256}));
}

TEST(ShadowMapBytes, RefuseSidesAndRadiiOutsideOfTheirLimits) {
  for (const ShadowMapSettings settings :
       {ShadowMapSettings{.side_px = 0}, ShadowMapSettings{.side_px = kLeastMapSide_px - 1},
        ShadowMapSettings{.side_px = kMostMapSide_px + 1},
        ShadowMapSettings{.pcf_radius = kMostPcfRadius + 1}}) {
    const Expected<std::uint64_t> bytes = shadow_map_bytes(with_point_lights(1), settings);
    ASSERT_FALSE(bytes);
    EXPECT_EQ(bytes.error().fault, Fault::OutOfRange);
  }
}

/// A node that moves and one that does not, and an instance at each.
Scene half_moving(std::size_t fixed_lights, std::size_t moving_lights) {
  Scene scene;
  scene.nodes.resize(2);
  scene.nodes[1].moving = true;
  scene.instances = {{.node = 0}, {.node = 1}};
  LightSource moving;
  moving.node = 1;
  scene.lights.resize(fixed_lights);
  scene.lights.resize(fixed_lights + moving_lights, moving);
  return scene;
}

TEST(MapLayers, KeepDepthForLightsThatCanStandStillWhileSomethingMoves) {
  const MapLayers layers = map_layers(half_moving(1, 2), {});
  EXPECT_EQ(layers.count, 18u);
  EXPECT_EQ(layers.kept, 6u);
  EXPECT_EQ(layers.kept_pair[2], 2u);
  EXPECT_FALSE(layers.kept_pair[3]);
  EXPECT_EQ(map_layers(half_moving(1, 2), {.redraw = Redraw::Always}).kept, 0u);
  EXPECT_EQ(map_layers(half_moving(0, 2), {}).kept, 0u);
  for (const bool all_move : {false, true}) {
    Scene scene = half_moving(1, 2);
    for (Instance& instance : scene.instances) instance.node = all_move;
    EXPECT_EQ(map_layers(scene, {}).kept, 0u) << all_move;
  }
}

TEST(MapLayers, OfAnAnimatedConeAreThoseOfTheWidest) {
  Scene scene = half_moving(1, 0);
  scene.lights[0].kind = LightKind::Spot;
  scene.lights[0].outer_cone_rad = 1.5f;  // the widest
  Light light;
  light.kind = LightKind::Spot;
  light.direction = {{0, -1, 0}};
  light.outer_cone_rad = 0.5f, light.widest_cone_rad = 1.5f;
  const std::vector<Point<Stage>> corners(8);
  const auto layers = [&] { return shadow_map_views({&light, 1}, corners, {}).layer_clip; };
  EXPECT_EQ(layers().size(), map_layers(scene, {}).count) << "a cube";
  light.widest_cone_rad = 0.9f;
  const std::vector<glm::dmat4> before = layers();
  ASSERT_EQ(before.size(), 1u);
  light.outer_cone_rad = 0.8f;
  EXPECT_EQ(layers(), before) << "its map is kept";
}

TEST(MapLayers, KeepNothingIfItDoesNotFitIntoTheBudgetWithTheMaps) {
  EXPECT_EQ(map_layers(half_moving(21, 0), {.side_px = 1024}).kept, 21u * 6);
  EXPECT_EQ(map_layers(half_moving(22, 0), {.side_px = 1024}).kept, 0u);
  EXPECT_EQ(shadow_map_bytes(half_moving(21, 0), {.side_px = 1024}).value(), 2 * 21 * 6ull << 22);
  EXPECT_EQ(shadow_map_bytes(half_moving(22, 0), {.side_px = 1024}).value(), 22 * 6ull << 22);
}

}  // namespace
}  // namespace farshade
