/// The lists of a light buffer are compared with brute force in double. The lookup rounds as
/// shaders/edge_rays.comp does.
#include "stereo/edge_rays/light_buffer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "stereo/gltf/gltf.h"
#include "stereo/plan/scene_plan.h"

namespace farshade {
namespace {

constexpr float kSide = FARSHADE_LIGHT_BUFFER_SIDE;
constexpr std::uint32_t kTexels = FARSHADE_LIGHT_BUFFER_SIDE * FARSHADE_LIGHT_BUFFER_SIDE;
constexpr std::uint32_t kParts = FARSHADE_LIGHT_BUFFER_PARTS;
constexpr float kCone_rad = 0.3f;

using Corners = std::array<glm::dvec3, 3>;

Corners corners_of(const CasterTriangles& casters, std::size_t triangle, Point<Stage> about) {
  Corners corners;
  for (std::size_t c = 0; c < 3; ++c)
    corners[c] = casters.origin.v - about.v + glm::dvec3(casters.corners[triangle][c]);
  return corners;
}

MapView view_of(const Light& light, const CasterTriangles& casters) {
  std::vector<Point<Stage>> places;
  for (std::size_t t = 0; t < casters.corners.size(); ++t)
    for (const glm::dvec3& corner : corners_of(casters, t, {})) places.push_back({corner});
  ShadowMapSettings settings;
  settings.side_px = FARSHADE_LIGHT_BUFFER_SIDE;
  settings.pcf_radius = 0;
  return shadow_map_views({&light, 1}, places, settings).lights[0].view;
}

Light light_of(LightKind kind, const glm::dvec3& position) {
  return {.kind = kind,
          .position = {position},
          .direction = {glm::normalize(glm::dvec3(0.3, -0.8, 0.45))},
          .outer_cone_rad = kCone_rad,
          .widest_cone_rad = kCone_rad};
}

std::uint32_t layer_of(const MapView& view, const glm::vec3& from_light) {
  if (view.kind != FARSHADE_MAP_CUBE) return 0;
  const glm::vec3 size = glm::abs(from_light);
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  return static_cast<std::uint32_t>(2 * axis + (from_light[axis] < 0 ? 1 : 0));
}

constexpr std::size_t kManyWords = 1 << 24;

LightBuffer made(const MapView& view, const CasterTriangles& casters) {
  return make_light_buffer(view, casters, kManyWords).value();
}

/// texel_of of edge_rays.comp.
std::uint32_t texel_of(const MapView& view, const glm::vec3& from_light, glm::vec2& inside) {
  const std::uint32_t layer = layer_of(view, from_light);
  glm::vec2 at;
  if (view.kind == FARSHADE_MAP_CUBE) {
    const glm::vec3 p = layer < 2   ? glm::vec3(from_light.z, from_light.y, from_light.x)
                        : layer < 4 ? glm::vec3(from_light.x, from_light.z, from_light.y)
                                    : from_light;
    at = glm::vec2(p) / std::abs(p.z);
  } else {
    const glm::vec3 p(glm::dot(from_light, glm::vec3(view.right)), glm::dot(from_light, glm::vec3(view.up)),
                      glm::dot(from_light, glm::vec3(view.ahead)));
    at = view.kind == FARSHADE_MAP_PARALLEL ? glm::vec2(p) : glm::vec2(p) / p.z;
  }
  const glm::vec2 texels(view.texels);
  at = glm::clamp(at * glm::vec2(texels.x, -texels.y) + 0.5f * kSide, glm::vec2(0), glm::vec2(kSide - 1e-3f));
  inside = glm::fract(at);
  return (layer * FARSHADE_LIGHT_BUFFER_SIDE + static_cast<std::uint32_t>(at.y)) *
             FARSHADE_LIGHT_BUFFER_SIDE +
         static_cast<std::uint32_t>(at.x);
}

/// The words of a list.
std::vector<std::uint32_t> list_from(const LightBuffer& buffer, std::uint32_t word) {
  std::vector<std::uint32_t> list;
  for (std::size_t i = word; word != 0; ++i) {
    list.push_back(buffer.at(i) & ~FARSHADE_LAST);
    if ((buffer.at(i) & FARSHADE_LAST) != 0) break;
  }
  return list;
}

/// depth_of of edge_rays.comp.
float depth_of(const MapView& view, const glm::vec3& from_light) {
  const glm::vec3 size = glm::abs(from_light);
  return view.kind == FARSHADE_MAP_CUBE ? std::max({size.x, size.y, size.z})
                                        : glm::dot(from_light, glm::vec3(view.ahead));
}

/// The triangles that edge_rays.comp tests for a point.
std::vector<std::uint32_t> list_at(const MapView& view, const CasterTriangles& casters,
                                   const LightBuffer& buffer, const glm::vec3& from_light) {
  glm::vec2 inside;
  std::uint32_t word = buffer.at(texel_of(view, from_light, inside));
  for (int division = 0; division < FARSHADE_LIGHT_BUFFER_DIVISIONS; ++division) {
    inside *= float{kParts};
    const glm::uvec2 part(inside);
    inside -= glm::vec2(part);
    if ((word & FARSHADE_DIVIDED) != 0)
      word = buffer.at((word & ~FARSHADE_DIVIDED) + part.y * kParts + part.x);
  }
  EXPECT_EQ(word & FARSHADE_DIVIDED, 0u) << "too many divisions";
  const ListDepths depths = list_depths(view, casters);
  const auto first = static_cast<float>(depths.first_m), step = static_cast<float>(depths.step_m);
  const float beyond = step > 0 ? (depth_of(view, from_light) - first) / step + 1 : 1e30f;
  std::vector<std::uint32_t> tested;
  for (const std::uint32_t triangle : list_from(buffer, word)) {
    tested.push_back(triangle & ((1u << depths.number_bits) - 1));
    if (static_cast<float>(triangle >> depths.number_bits) > beyond) break;
  }
  return tested;
}

/// Whether a triangle lies between the light and a point. Everything is relative to the light. A triangle
/// hides nothing if the light is in its plane, within rounding.
bool is_between(const Corners& corners, const glm::dvec3& point, const MapView& view) {
  const auto& [a, b, c] = corners;
  const bool parallel = view.kind == FARSHADE_MAP_PARALLEL;
  const glm::dvec3 along = parallel ? view.ahead : point, from = parallel ? point : glm::dvec3(0.0);
  const glm::dvec3 n = glm::cross(b - a, c - a);
  const double size = std::max({glm::length(a), glm::length(b), glm::length(c)}), across = glm::dot(n, along);
  const double distance = glm::dot(n, a - from);
  if (across == 0 || (!parallel && std::abs(distance) <= 1e-8 * size * glm::length(n))) return false;
  const double t = distance / across;  // of `along`, from `from` on
  if (parallel ? t >= 0 : t <= 0 || t >= 1) return false;
  const glm::dvec3 hit = from + along * t;
  const auto side = [&](const glm::dvec3& u, const glm::dvec3& v) {
    return glm::dot(n, glm::cross(v - u, hit - u));
  };
  return side(a, b) >= 0 && side(b, c) >= 0 && side(c, a) >= 0;
}

/// Expects that the list of a point's texel holds each triangle that hides the point, or another one that
/// does so too and has no holes. `eye` is where a client's floats are relative to. Returns whether something
/// hides the point.
bool expect_found(const MapView& view, const CasterTriangles& casters, const LightBuffer& buffer,
                  const glm::dvec3& from_light, const glm::dvec3& eye) {
  const glm::vec3 seen(view.origin.v + from_light - eye);
  const glm::dvec3 point = eye + glm::dvec3(seen) - view.origin.v;
  const std::vector<std::uint32_t> list =
      list_at(view, casters, buffer, seen - glm::vec3(view.origin.v - eye));
  const auto hides = [&](std::size_t t) {
    return is_between(corners_of(casters, t, view.origin), point, view);
  };
  const bool hidden =
      std::ranges::any_of(list, [&](std::uint32_t t) { return !casters.has_holes[t] && hides(t); });
  bool some = hidden;
  for (std::uint32_t t = 0; t < casters.corners.size() && !hidden; ++t) {
    if (!hides(t)) continue;
    some = true;
    EXPECT_TRUE(std::ranges::count(list, t) == 1) << "triangle " << t << " of a list of " << list.size();
  }
  return some;
}

class Random {
 public:
  explicit Random(std::uint64_t seed) : random_(seed) {}
  double between(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }
  /// Every power of ten is as likely.
  double size(double low, double high) { return std::exp(between(std::log(low), std::log(high))); }
  glm::dvec3 in_cube(double half) {
    return {between(-half, half), between(-half, half), between(-half, half)};
  }
  std::size_t below(std::size_t count) {
    return std::min(count - 1, static_cast<std::size_t>(between(0, double(count))));
  }
  glm::dvec3 inside(const Corners& corners) {
    const double u = between(0, 1), v = between(0, 1 - u);
    return corners[0] * (1 - u - v) + corners[1] * u + corners[2] * v;
  }

 private:
  std::mt19937_64 random_;
};

/// A direction of a layer that lies on the border of a texel or of a part.
glm::dvec3 at_border(const MapView& view, const glm::dvec3& from_light) {
  const MapView layer =
      view.kind == FARSHADE_MAP_CUBE ? face_view(view, layer_of(view, glm::vec3(from_light))) : view;
  const double depth = view.kind == FARSHADE_MAP_PARALLEL ? 1.0 : glm::dot(from_light, layer.ahead);
  const double parts = layer.texels.x / depth * kParts * kParts;
  const double x = glm::dot(from_light, layer.right);
  return from_light + layer.right * (std::round(x * parts) / parts - x);
}

/// Points behind triangles and anywhere, some at borders of texels. Returns the number of those that
/// something hides.
int check_points(const MapView& view, const CasterTriangles& casters, double scale, int points,
                 Random& random) {
  const LightBuffer buffer = made(view, casters);
  int hidden = 0;
  for (int i = 0; i < points && !testing::Test::HasFailure(); ++i) {
    const std::size_t t = random.below(casters.corners.size());
    glm::dvec3 p = random.inside(corners_of(casters, t, view.origin));
    if (view.kind == FARSHADE_MAP_PARALLEL)
      p += view.ahead * (random.size(1e-6, 1) * scale);
    else
      p *= 1 + random.size(1e-5, 3);
    if (i % 4 == 0) p = random.in_cube(2 * scale);
    if (view.kind == FARSHADE_MAP_WINDOW && i % 3 == 0)
      p = (view.ahead + random.in_cube(0.15)) * random.between(0, 2 * scale);
    if (i % 2 == 0) p = at_border(view, p);
    const bool lit =
        view.kind != FARSHADE_MAP_WINDOW || glm::dot(p, view.ahead) > std::cos(kCone_rad) * glm::length(p);
    if (lit && glm::length(p) > 1e-3 * scale)
      hidden += expect_found(view, casters, buffer, p, view.origin.v + random.in_cube(scale)) ? 1 : 0;
  }
  return hidden;
}

/// Triangles in a cube of half a side of `scale` around a light: tiny, medium and huge ones, some edge-on to
/// the light, some through it and some next to it.
CasterTriangles soup(std::size_t count, double scale, const glm::dvec3& light, Random& random) {
  CasterTriangles casters{.origin = {light + random.in_cube(0.5 * scale)}, .corners = {}, .has_holes = {}};
  const std::array<double, 4> sizes{1e-3, 0.1, 3, 0.5};
  for (std::size_t i = 0; i < count; ++i) {
    const double near = i % 7 == 0 ? random.size(1e-6, 1e-1) : 1;  // next to the light
    Corners corners;
    const glm::dvec3 middle = random.in_cube(1);
    for (glm::dvec3& corner : corners) corner = (middle + random.in_cube(sizes[i % sizes.size()])) * near;
    if (i % 11 == 0) corners[2] = corners[0] * random.between(-2, 2) + corners[1] * random.between(-2, 2);
    if (i % 11 == 1) corners[2] -= corners[0] + corners[1];
    if (i % 33 == 0) corners[2] += random.in_cube(random.size(1e-7, 1e-2));
    std::array<glm::vec3, 3> stored;
    for (std::size_t c = 0; c < 3; ++c) stored[c] = glm::vec3(corners[c] * scale + light - casters.origin.v);
    casters.corners.push_back(stored);
    casters.has_holes.push_back(random.below(4) == 0);
  }
  return casters;
}

/// The kind of light, the size of the scene and its distance from the stage's origin.
class LightBufferOf : public testing::TestWithParam<std::tuple<LightKind, double, double>> {};

TEST_P(LightBufferOf, HoldsWhatHidesAPoint) {
  const auto [kind, scale, far] = GetParam();
  int hidden = 0;
  for (std::uint64_t seed = 1; seed <= 100 && !HasFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    const Light light = light_of(kind, glm::dvec3(0.6, -0.64, 0.48) * far + random.in_cube(scale));
    const CasterTriangles casters = soup(seed % 3 == 0 ? 60 : 12, scale, light.position.v, random);
    hidden += check_points(view_of(light, casters), casters, scale, 250, random);
  }
  EXPECT_GT(hidden, 2000);
}

INSTANTIATE_TEST_SUITE_P(Scenes, LightBufferOf,
                         testing::Combine(testing::Values(LightKind::Point, LightKind::Spot,
                                                          LightKind::Directional),
                                          testing::Values(1e-3, 5.0, 1e4), testing::Values(0.0, 1e6)));

TEST(LightBuffer, OfTheRoomHoldsWhatHidesAPoint) {
  const auto scene = load_scene(FARSHADE_ASSETS "/room.glb");
  ASSERT_TRUE(scene);
  const CasterTriangles casters = caster_triangles(*scene, plan_for(*scene).draw);
  Random random(5);
  for (const LightKind kind : {LightKind::Point, LightKind::Spot, LightKind::Directional}) {
    const MapView view = view_of(light_of(kind, {0.4, 2.1, -0.3}), casters);
    EXPECT_GT(check_points(view, casters, 3, 500, random), 50);
  }
}

/// Three corners around the middle of the face -z of a light at the origin, `half` wide.
std::array<glm::vec3, 3> ahead(float distance, float half) {
  return {{{-half, -half, -distance}, {half, -half, -distance}, {0.01f * half, half, -distance}}};
}

const MapView kCube =
    view_of(light_of(LightKind::Point, {}), {.origin = {}, .corners = {ahead(1, 1)}, .has_holes = {false}});
const glm::vec3 kAhead(0.001f, -0.001f, -9);

TEST(LightBuffer, ListsTheNearestFirstAndEndsAtWhatCoversTheTexel) {
  const CasterTriangles casters{
      .origin = {},
      .corners = {ahead(3, 0.01f), ahead(1, 0.01f), ahead(5, 0.01f), ahead(4, 2), ahead(2, 0.01f)},
      .has_holes = std::vector<bool>(5)};
  const LightBuffer buffer = made(kCube, casters);
  EXPECT_EQ(list_at(kCube, casters, buffer, kAhead), (std::vector<std::uint32_t>{1, 4, 0, 3}));
  EXPECT_TRUE(list_at(kCube, casters, buffer, -kAhead).empty());
}

/// Four triangles, of which none covers the texel.
TEST(LightBuffer, SaysWhichTrianglesBeginBeyondAPoint) {
  const CasterTriangles casters{
      .origin = {},
      .corners = {ahead(3, 0.01f), ahead(1, 0.01f), ahead(5, 0.01f), ahead(4, 0.01f)},
      .has_holes = std::vector<bool>(4)};
  const LightBuffer buffer = made(kCube, casters);
  const auto tested = [&](float depth) {
    return list_at(kCube, casters, buffer, glm::vec3(0.0001f, -0.0001f, -1) * depth).size();
  };
  // A ray ends at the first one that begins beyond its point by more than a step.
  EXPECT_EQ(tested(0.9f), 1u);
  EXPECT_EQ(tested(1.1f), 2u);
  EXPECT_EQ(tested(3.5f), 3u);
  EXPECT_EQ(tested(6), 4u);

  EXPECT_EQ(list_depths(kCube, casters).number_bits, 3u);
  EXPECT_NEAR(list_depths(kCube, casters).step_m, 5.0 / 65535, 1e-6);
}

TEST(LightBuffer, DoesNotEndAtATriangleWithHoles) {
  const CasterTriangles casters{
      .origin = {}, .corners = {ahead(1, 1), ahead(2, 1)}, .has_holes = {true, false}};
  EXPECT_EQ(list_at(kCube, casters, made(kCube, casters), kAhead), (std::vector<std::uint32_t>{0, 1}));
}

TEST(LightBuffer, HoldsATiltedTriangleThatCoversATexelBehindItsNearestPoint) {
  std::array<glm::vec3, 3> tilted = ahead(4, 3);
  tilted[2] *= 0.25f;
  const CasterTriangles casters{
      .origin = {}, .corners = {tilted, ahead(2, 0.5f)}, .has_holes = {false, false}};
  EXPECT_EQ(list_at(kCube, casters, made(kCube, casters), kAhead), (std::vector<std::uint32_t>{0, 1}));
}

TEST(LightBuffer, OfASunHoldsWhatLiesJustBeforeATriangleThatCoversATexel) {
  Light sun = light_of(LightKind::Directional, {});
  sun.direction = {{0, 0, -1}};
  const CasterTriangles casters{.origin = {},
                                .corners = {ahead(0, 9000), ahead(-0.005f, 9000), ahead(1e4f, 9000)},
                                .has_holes = {false, false, false}};
  const MapView view = view_of(sun, casters);
  const std::vector<std::uint32_t> list =
      list_at(view, casters, made(view, casters), glm::vec3(-view.origin.v));
  EXPECT_EQ(list, (std::vector<std::uint32_t>{1, 0}));
}

TEST(LightBuffer, PutsNothingBehindATriangleInWhosePlaneTheLightLies) {
  const glm::vec3 u(1, 0.3f, -0.5f), v(-0.4f, 1, 0.6f);
  const CasterTriangles casters{.origin = {},
                                .corners = {{{u * 4.0f, v * 4.0f, u * -4.0f - v * 4.0f}}, ahead(5, 9)},
                                .has_holes = {false, false}};
  const LightBuffer buffer = made(kCube, casters);
  for (float x = -5; x < 5; x += 0.1f)
    for (float y = -5; y < 4; y += 0.1f) {
      const bool hidden = is_between(corners_of(casters, 1, {}), {x, y, -9}, kCube);
      EXPECT_EQ(list_at(kCube, casters, buffer, {x, y, -9}).empty(), !hidden) << x << ' ' << y;
    }
}

/// Checks a texel and its parts, and counts the words that belong to them.
void expect_valid(const LightBuffer& buffer, std::size_t texel, int divisions, std::size_t triangles,
                  std::uint32_t number_bits, std::size_t& words) {
  const std::uint32_t word = buffer.at(texel);
  if ((word & FARSHADE_DIVIDED) != 0) {
    ASSERT_LT(divisions, FARSHADE_LIGHT_BUFFER_DIVISIONS);
    for (std::size_t part = 0; part < kParts * kParts; ++part)
      expect_valid(buffer, (word & ~FARSHADE_DIVIDED) + part, divisions + 1, triangles, number_bits, words);
    words += kParts * kParts;
    return;
  }
  const std::vector<std::uint32_t> list = list_from(buffer, word);
  for (const std::uint32_t triangle : list) EXPECT_LT(triangle & ((1u << number_bits) - 1), triangles);
  EXPECT_EQ(std::set(list.begin(), list.end()).size(), list.size()) << "a triangle is listed twice";
  words += list.size();
}

TEST(LightBuffer, IsMadeOfTexelsPartsAndListsAndIsTheSameEachTime) {
  Random random(3);
  const CasterTriangles casters = soup(200, 5, {}, random);
  for (const LightKind kind : {LightKind::Point, LightKind::Spot, LightKind::Directional}) {
    const MapView view = view_of(light_of(kind, {}), casters);
    const LightBuffer buffer = made(view, casters);
    const std::size_t texels = kTexels * (kind == LightKind::Point ? 6u : 1u);
    std::size_t words = texels;
    for (std::size_t texel = 0; texel < texels; ++texel)
      expect_valid(buffer, texel, 0, casters.corners.size(), list_depths(view, casters).number_bits, words);
    EXPECT_EQ(words, buffer.size());
    EXPECT_EQ(made(view, casters), buffer);
  }
}

TEST(LightBuffer, HasNoMoreWordsThanItMay) {
  Random random(3);
  const CasterTriangles casters = soup(200, 5, {}, random);
  for (const LightKind kind : {LightKind::Point, LightKind::Spot, LightKind::Directional}) {
    const MapView view = view_of(light_of(kind, {}), casters);
    const LightBuffer buffer = made(view, casters);
    EXPECT_EQ(make_light_buffer(view, casters, buffer.size()), buffer);
    EXPECT_FALSE(make_light_buffer(view, casters, buffer.size() - 1));
    EXPECT_FALSE(make_light_buffer(view, casters, 0));
  }
}

TEST(LightBuffer, OfNothingIsEmptyLists) {
  EXPECT_EQ(made(kCube, {}), LightBuffer(6 * std::size_t{kTexels}));
}

}  // namespace
}  // namespace farshade
