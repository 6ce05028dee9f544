// Compares the tracer with the oracle on the bundled scenes and on random ones, and with a result on paper.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "stereo/gltf/gltf.h"
#include "stereo/scene/sky.h"
#include "tests/oracle/agreement.h"
#include "tests/oracle/random_scenes.h"
#include "tests/oracle/scene_builder.h"
#include "tests/oracle/surfaces.h"
#include "tests/support/sanitized.h"

namespace farshade {
namespace {

/// The scene's reference camera turned by `yaw_rad`, as two asymmetric eyes 64 mm apart.
StereoView reference_eyes(const Scene& scene, double yaw_rad, Extent size) {
  const Rigid<Stage, Eye> camera = scene.camera.value();
  const Rigid<Stage, Eye> turned{glm::angleAxis(yaw_rad, glm::dvec3(0, 1, 0)) * camera.rotation,
                                 camera.translation};
  const auto eye = [&](double x, double left, double right) {
    const Rigid<Stage, Eye> stage_from_eye{turned.rotation, turned(Point<Eye>{{x, 0, 0}}).v};
    return View{stage_from_eye, {-left, right, 0.74, -0.85}, size};
  };
  return {eye(-0.032, 0.94, 0.70), eye(0.032, 0.70, 0.94)};
}

TEST(ShadowTrace, AgreesWithTheOracleOnBoxOverPlane) {
  const Scene scene = load_scene(FARSHADE_ASSETS "/box_over_plane.gltf").value();
  for (const double yaw : {0.0, 0.4, -0.5}) {
    SCOPED_TRACE(yaw);
    expect_agrees(scene, reference_eyes(scene, yaw, {128, 128}), Time{}, 0.015);
  }
}

TEST(ShadowTrace, AgreesWithTheOracleInTheRoom) {
  const Scene scene = load_scene(FARSHADE_ASSETS "/room.glb").value();
  const std::array<double, 3> yaws{0.0, 1.3, -2.2};
  for (std::size_t i = 0; i < (kSanitized ? 1 : yaws.size()); ++i) {
    SCOPED_TRACE(yaws[i]);
    const Time time = time_from_ns(static_cast<std::int64_t>(i) * 1'300'000'000);
    const oracle::Agreement sum =
        expect_agrees(scene, reference_eyes(scene, yaws[i], {128, 112}), time, 0.11);
    EXPECT_GT(sum.lit, sum.pixel_lights / 20);
  }
}

/// In each scene, moving meshes surround two of the lights.
TEST(ShadowTrace, AgreesWithTheOracleOnRandomSoups) {
  const unsigned seed = 20261123;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  for (int i = 0; i < 6; ++i) {
    SCOPED_TRACE(i);
    const Scene scene = random_soup(random);
    const double angle = 1.1 * i;
    const View view = look({2.5 * std::sin(angle), 0.3, 2.5 * std::cos(angle)}, {0.1, -0.8, 0}, 96);
    const oracle::Agreement sum =
        expect_agrees(scene, {view, view}, time_from_ns(std::int64_t{i} * 150'000'000), 0.15);
    EXPECT_GT(sum.lit, sum.pixel_lights / 50);
  }
}

/// Skins and morph targets at random times, near the origin and 10 km from it.
TEST(ShadowTrace, AgreesWithTheOracleOnDeformedFigures) {
  const unsigned seed = 20261125;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  for (int i = 0; i < 6; ++i) {
    SCOPED_TRACE(i);
    const glm::dvec3 shift(i < 3 ? 0.0 : 1e4, 0, 0);
    const Scene scene = bending_figures(random, 2000, shift);
    const View view = look(shift + glm::dvec3(std::sin(1.1 * i), 1.6, 3), shift + glm::dvec3(0, 0.8, 0), 128);
    const Time time(std::chrono::milliseconds(std::uniform_int_distribution(0, 999)(random)));
    const oracle::Agreement sum = expect_agrees(scene, {view, view}, time, 0.1);
    EXPECT_GT(sum.lit, sum.pixel_lights / 10);
  }
}

/// Ranges and cones at random times, with one tracer for all times and another for each.
TEST(ShadowTrace, AgreesWithTheOracleOnChangingLights) {
  const unsigned seed = 20261126;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  for (int i = 0; i < 3; ++i) {
    const Scene scene = changing_lights(random);
    const View view = look({0.5 * i, 2.5, 3}, {0, -1, 0}, 128);
    std::array<std::uint64_t, 2> lit{};
    for (std::size_t late = 0; late < lit.size(); ++late) {
      const int first_ms = late == 1 ? 900 : 0;
      const Time time(
          std::chrono::milliseconds(std::uniform_int_distribution(first_ms, first_ms + 99)(random)));
      lit[late] = expect_agrees(scene, {view, view}, time, 0.1).lit;
    }
    EXPECT_GT(std::min(lit[0], lit[1]), 1000u);
    EXPECT_NE(lit[0], lit[1]);
  }
}

/// Edges of a shadow on the plane y = 0, as assets/ORIGIN.md derives them.
struct Rectangle {
  double x0, x1, z0, z1;

  /// Distance to the outline, positive inside.
  [[nodiscard]] double inside_by(const glm::dvec3& p) const {
    return std::min(std::min(p.x - x0, x1 - p.x), std::min(p.z - z0, z1 - p.z));
  }
};

/// A sun shines through an unlit box around the scene, also while that turns.
TEST(ShadowTrace, PassesASky) {
  for (const bool turns : {false, true}) {
    SceneBuilder builder;
    builder.add(quad({0, 0, 0}, {0, 0, 4}, {4, 0, 0}));
    builder.add(box({0, 1.0f, 0}, {0.5f, 0.3f, 0.5f}));
    Material unlit;
    unlit.unlit = unlit.double_sided = true;
    const std::uint32_t sky = builder.add(box({0, 0, 0}, {50, 50, 50}), builder.material(unlit));
    if (turns) builder.turn(sky, 1.0);
    builder.directional_light({0.3, -1, 0.2});
    builder.point_light({60, 30, 0});
    Scene scene = builder.build();
    const View view = look({3, 3, 4}, {0, 0.5, 0}, 96);
    const Time time = time_from_ns(300'000'000);
    EXPECT_LT(expect_agrees(scene, {view, view}, time, 0.05).lit, 100u) << "it would block both lights";
    find_sky(scene);
    const oracle::Agreement sum = expect_agrees(scene, {view, view}, time, 0.05);
    EXPECT_GT(sum.lit, sum.pixel_lights / 4);
    const ShadowFrame proved = traced(scene, {view, view}, time),
                      sure = reference_traced(scene, {view, view}, time);
    EXPECT_TRUE(proved.masks == sure.masks);
  }
}

TEST(ShadowTrace, MatchesPaperAnswerForBoxOverPlane) {
  const Scene scene = load_scene(FARSHADE_ASSETS "/box_over_plane.gltf").value();
  const std::array<Rectangle, 2> shadows{Rectangle{-0.95, 0.65, -0.8, 0.8}, Rectangle{0.5, 2.0, -0.5, 0.5}};
  // The eye is between plane and box, so it sees only the plane.
  const View view = look({0.3, 0.95, 0.001}, {0.3, 0.0, 0.0}, 256, 2.3);
  const ShadowFrame frame = traced(scene, view);
  const FovTangents window = tangents_of(view.fov);
  std::array<int, 2> dark{};
  for (std::uint32_t y = 0; y < view.size.height; ++y)
    for (std::uint32_t x = 0; x < view.size.width; ++x) {
      const glm::dvec3 toward =
          view.stage_from_eye(Vector<Eye>{pixel_ray(window, view.size, {x + 0.5, y + 0.5})}).v;
      const glm::dvec3 point = view.stage_from_eye.translation + toward * (-0.95 / toward.y);
      for (std::uint32_t light = 0; light < 2; ++light) {
        const double inside_by = shadows[light].inside_by(point);
        if (std::abs(inside_by) < 2e-5) continue;  // rounding of the file and of the tracer
        ASSERT_EQ(frame.masks[0].lit(x, y, light), inside_by < 0)
            << point.x << ", " << point.z << " light " << light;
        dark[light] += inside_by > 0;
      }
    }
  EXPECT_GT(dark[0], 5000);
  EXPECT_GT(dark[1], 2000);
}

/// A ball of radius 1 with smooth normals.
Mesh smooth_ball(std::uint32_t around, std::uint32_t up) {
  Mesh mesh;
  for (std::uint32_t j = 0; j <= up; ++j)
    for (std::uint32_t i = 0; i < around; ++i) {
      const double elevation = std::numbers::pi * (static_cast<double>(j) / up - 0.5);
      const double azimuth = 2 * std::numbers::pi * i / around;
      mesh.positions.emplace_back(std::cos(elevation) * std::cos(azimuth), std::sin(elevation),
                                  -std::cos(elevation) * std::sin(azimuth));
      const std::uint32_t a = j * around + i, b = j * around + (i + 1) % around;
      if (j < up)
        mesh.triangles.insert(mesh.triangles.end(), {{a, b, b + around}, {a, b + around, a + around}});
    }
  mesh.normals = mesh.positions;
  return mesh;
}

/// The pixel-lights of a smooth ball whose shading normal faces the light, under 32 suns all around.
struct Terminator {
  std::size_t facing = 0, dark = 0;
  double light = 0, lost_light = 0;  ///< sums of N . L
  double widest_rad = 0;             ///< of a dark pixel-light from the plane N . L = 0
};

Terminator terminator_of(std::uint32_t around, std::uint32_t up) {
  SceneBuilder builder;
  builder.add(smooth_ball(around, up));
  constexpr int kSuns = 32;
  std::vector<glm::dvec3> to_suns;
  for (int i = 0; i < kSuns; ++i) {
    const double y = 1 - (2 * i + 1.0) / kSuns, r = std::sqrt(1 - y * y), azimuth = 2.4 * i;
    to_suns.emplace_back(r * std::cos(azimuth), y, r * std::sin(azimuth));
    builder.directional_light(-to_suns.back());
  }
  const Scene scene = builder.build();
  const View view = look({1, 0.7, 2.3}, {0, 0, 0}, 128, 0.9);
  expect_agrees(scene, {view, view}, Time{}, 0.05);
  const EyeMask mask = traced(scene, view).masks[0];
  const oracle::Surfaces surfaces(scene, state_at(scene, Time{}), oracle::Search::Tree);
  const FovTangents window = tangents_of(view.fov);
  Terminator sum;
  for (std::uint32_t y = 0; y < view.size.height; ++y)
    for (std::uint32_t x = 0; x < view.size.width; ++x) {
      const glm::dvec3 eye = view.stage_from_eye.translation;
      const glm::dvec3 ray =
          view.stage_from_eye(Vector<Eye>{pixel_ray(window, view.size, {x + 0.5, y + 0.5})}).v;
      const std::optional<oracle::Hit> hit = surfaces.nearest({eye, ray});
      if (!hit) continue;
      const glm::dvec3 normal = glm::normalize(eye + hit->t * ray);  // on a ball, the normals' mean is there
      for (std::uint32_t sun = 0; sun < kSuns; ++sun) {
        const double strength = glm::dot(normal, to_suns[sun]);
        if (strength <= 0) continue;
        ++sum.facing, sum.light += strength;
        if (mask.lit(x, y, sun)) continue;
        ++sum.dark, sum.lost_light += strength;
        sum.widest_rad = std::max(sum.widest_rad, std::asin(strength));
      }
    }
  return sum;
}

/// docs/tracing.md has the figures that this prints.
TEST(ShadowTrace, DarkensTrianglesAtTheTerminatorOfSmoothMeshes) {
  struct Case {
    std::uint32_t around, up;
    double dark_percent, lost_percent, widest_deg;
  };
  for (const Case& of :
       {Case{8, 6, 6.2, 1.22, 23.0}, Case{16, 12, 3.8, 0.43, 12.1}, Case{32, 24, 1.8, 0.09, 5.6}}) {
    const Terminator ball = terminator_of(of.around, of.up);
    const double dark = 100.0 * static_cast<double>(ball.dark) / static_cast<double>(ball.facing),
                 lost = 100 * ball.lost_light / ball.light, widest = ball.widest_rad * 180 / std::numbers::pi;
    fmt::print(
        "{:2} x {:2} segments: {:.1f} % of the pixel-lights that face the light are dark, {:.2f} % of "
        "the light is lost, up to {:.1f} degrees from the terminator\n",
        of.around, of.up, dark, lost, widest);
    EXPECT_NEAR(dark, of.dark_percent, 0.1);
    EXPECT_NEAR(lost, of.lost_percent, 0.01);
    EXPECT_NEAR(widest, of.widest_deg, 0.2);
  }
}

}  // namespace
}  // namespace farshade
