#include "stereo/raster/frame_data.h"

#include <gtest/gtest.h>

#include <glm/ext/matrix_transform.hpp>
#include <random>

#include "stereo/math/rotation.h"

namespace farshade {
namespace {

/// The largest error of float with coordinates of 20 m is 0.002 px in the cases below, at both origins.
constexpr double kBound_px = 0.005;
constexpr Extent kSize{1024, 900};
constexpr int kCases = 2000;

class FrameData : public testing::TestWithParam<double> {
 protected:
  double between(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }
  glm::dvec3 in_cube(double half) {
    return {between(-half, half), between(-half, half), between(-half, half)};
  }

  /// Random eyes with different poses and fovs, `GetParam()` metres from the stage's origin.
  StereoView views() {
    StereoView made;
    const glm::dvec3 far = glm::dvec3(0.6, -0.64, 0.48) * GetParam();
    for (View& view : made)
      view = {{rotation_exp(in_cube(3)), far + in_cube(1)},
              {between(-1.2, -0.1), between(0.1, 1.2), between(0.1, 1.2), between(-1.2, -0.1)},
              kSize};
    return made;
  }
  /// A random point in front of `view` and within its fov.
  Point<Eye> seen_by(const View& view) {
    const glm::dvec2 pixel{between(0, kSize.width), between(0, kSize.height)};
    return {pixel_ray(tangents_of(view.fov), kSize, pixel) * between(0.3, 20)};
  }

  std::mt19937_64 random_{20};  // the seed
};

glm::dvec2 pixel_of(const View& view, Point<Stage> p) {
  return ray_pixel(tangents_of(view.fov), view.size, inverse(view.stage_from_eye)(p).v);
}

glm::dvec2 pixel_of_clip(const glm::vec4& clip) {
  return (glm::dvec2(clip) / double{clip.w} * 0.5 + 0.5) * glm::dvec2(kSize.width, kSize.height);
}

TEST_P(FrameData, ClipFromObjectProjectsAsRaysDo) {
  for (int i = 0; i < kCases; ++i) {
    const StereoView shown = views();
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      const Point<Stage> seen = shown[eye].stage_from_eye(seen_by(shown[eye]));
      glm::dmat4 placed =
          glm::translate(glm::dmat4(1.0), seen.v + in_cube(5)) * glm::mat4_cast(rotation_exp(in_cube(2)));
      placed = glm::scale(placed, {between(0.5, 2), -between(0.5, 2), between(0.5, 2)});
      const Affine<Stage, Object> stage_from_object{placed};
      // A vertex is float, so its position in the stage is computed from the rounded vertex.
      const glm::vec3 vertex(glm::inverse(placed) * glm::dvec4(seen.v, 1.0));
      const Point<Stage> p = stage_from_object(Point<Object>{glm::dvec3(vertex)});
      const gpu::InstanceData data = instance_data(shown, stage_from_object);
      const glm::dvec2 drawn = pixel_of_clip(data.clip_from_object[eye] * glm::vec4(vertex, 1.0f));
      const glm::dvec2 right = pixel_of(shown[eye], p);
      ASSERT_LT(glm::length(drawn - right), kBound_px) << "case " << i << ", eye " << eye;
    }
  }
}

TEST_P(FrameData, DepthIsNearPlaneOverDistance) {
  for (int i = 0; i < kCases; ++i) {
    const StereoView shown = views();
    const Point<Eye> p = seen_by(shown[1]);
    const Affine<Stage, Object> at{glm::translate(glm::dmat4(1.0), shown[1].stage_from_eye(p).v)};
    const glm::vec4 clip = instance_data(shown, at).clip_from_object[1] * glm::vec4(0, 0, 0, 1);
    ASSERT_NEAR(clip.z / clip.w * -p.v.z / kNearPlane_m, 1, 1e-6);
  }
}

TEST_P(FrameData, SourceDataCarriesAPointFromTheShownToTheTracedEye) {
  for (int i = 0; i < kCases; ++i) {
    const StereoView shown = views(), traced = views();
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      const gpu::SourceData data = source_data(pose_delta(shown[eye], {}, traced[eye], {}), traced[eye]);
      const Point<Eye> p = seen_by(shown[eye]);
      const Point<Eye> right = inverse(traced[eye].stage_from_eye)(shown[eye].stage_from_eye(p));
      const glm::dvec3 carried(data.traced_from_shown * glm::vec4(p.v, 1.0));
      ASSERT_LT(glm::length(carried - right.v), 2e-5) << "case " << i << ", eye " << eye;
      const FovTangents w = tangents_of(traced[eye].fov);
      const glm::dvec3 corner = pixel_ray(w, kSize, {kSize.width, kSize.height});
      ASSERT_NEAR(data.origin_step.x + data.origin_step.z * kSize.width, corner.x, 1e-5);
      ASSERT_NEAR(data.origin_step.y + data.origin_step.w * kSize.height, corner.y, 1e-5);
      ASSERT_NEAR(data.per_step.x * data.origin_step.z, 1, 1e-6);
      ASSERT_NEAR(data.per_step.y * data.origin_step.w, 1, 1e-6);
      ASSERT_EQ(glm::vec2(data.per_step.z, data.per_step.w), glm::vec2(kSize.width, kSize.height));
    }
  }
}

TEST_P(FrameData, SameViewsCarryPointsNowhere) {
  for (const View& view : views())
    EXPECT_EQ(source_data(pose_delta(view, {}, view, {}), view).traced_from_shown, glm::mat4(1.0f));
}

TEST_P(FrameData, LightsAreRelativeToEachEye) {
  const StereoView shown = views();
  Light light{.kind = LightKind::Point,
              .position = {shown[0].stage_from_eye.translation + glm::dvec3(1, 2, 3)},
              .direction = {},
              .intensity = {3, 4, 5}};
  const glm::dvec3 apart = shown[0].stage_from_eye.translation - shown[1].stage_from_eye.translation;
  gpu::LightData data = light_data(shown, light);
  EXPECT_LT(glm::length(glm::dvec4(data.position[0]) - glm::dvec4(1, 2, 3, 1)), 1e-6);
  EXPECT_LT(glm::length(glm::dvec4(data.position[1]) - glm::dvec4(glm::dvec3(1, 2, 3) + apart, 1)), 1e-6);
  EXPECT_EQ(data.intensity, glm::vec4(3, 4, 5, 0)) << "without a range there is no window";
  EXPECT_EQ(data.spot_cone, glm::vec4(0, 1, 0, 0)) << "without a cone the factor is 1 everywhere";
  light.range_m = 4;
  EXPECT_EQ(light_data(shown, light).intensity.w, 1.0f / 16);
}

INSTANTIATE_TEST_SUITE_P(OriginsAt_m, FrameData, testing::Values(0.0, 1e6));

TEST(FrameDataEye, TurnsEyeAxesToStageAxesAndNothingElse) {
  View view{{rotation_exp({0, 0.5, 0}), {7, 8, 9}}, {-0.7, 0.8, 0.6, -0.5}, {64, 32}};
  const gpu::EyeData data = eye_data(view);
  EXPECT_EQ(data.size_px, glm::vec4(64, 32, 1 / 64.0f, 1 / 32.0f));
  const glm::dvec3 ahead = view.stage_from_eye(Vector<Eye>{{0, 0, -1}}).v;
  EXPECT_LT(glm::length(glm::dvec4(data.stage_from_eye * glm::vec4(0, 0, -1, 1)) - glm::dvec4(ahead, 1)),
            1e-6);
}

TEST(FrameDataInstance, NormalsStayPerpendicularUnderUnevenAndMirroringScale) {
  const glm::dmat4 placed =
      glm::scale(glm::mat4_cast(rotation_exp({1, 2, 0.3})) * 1.0, glm::dvec3(3, -0.25, 1));
  const gpu::InstanceData data = instance_data({}, {placed});
  const glm::dvec3 u(1, 2, 0.5), v(-0.3, 1, 1), n = glm::cross(u, v);
  const glm::dvec3 normal = glm::normalize(glm::dvec3(data.stage_from_object_normal * glm::vec4(n, 0)));
  EXPECT_NEAR(glm::dot(normal, glm::normalize(glm::dmat3(placed) * u)), 0, 1e-6);
  EXPECT_NEAR(glm::dot(normal, glm::normalize(glm::dmat3(placed) * v)), 0, 1e-6);
  EXPECT_GT(glm::dot(normal, glm::dmat3(placed) * n), 0) << "still on the outside";
}

TEST(LightData, IsMultipliedByTheExposureAndStaysFinite) {
  Light light;
  light.intensity = {1, 2, 1e30f};
  const gpu::LightData data = light_data({}, light, {8});
  EXPECT_EQ(glm::vec3(data.intensity), glm::vec3(4, 8, 1e30f));
  EXPECT_EQ(light_data({}, light, {Exposure::kMostQuarterStops}).intensity.z, 1e30f);
}

TEST(FrameDataLight, DirectionalPointsTowardsTheLight) {
  const Light light{.kind = LightKind::Directional, .position = {}, .direction = {{0, -1, 0}}};
  const gpu::LightData data = light_data({}, light);
  EXPECT_EQ(data.position[0], glm::vec4(0, 1, 0, 0));
  EXPECT_EQ(data.position[1], glm::vec4(0, 1, 0, 0));
}

Light spot(float inner_rad, float outer_rad) {
  return {.kind = LightKind::Spot,
          .position = {},
          .direction = {{0, 0, -1}},
          .inner_cone_rad = inner_rad,
          .outer_cone_rad = outer_rad};
}

TEST(FrameDataLight, SpotFallsFromOneAtTheInnerToZeroAtTheOuterCone) {
  const gpu::LightData data = light_data({}, spot(0.3f, 0.6f));
  const auto factor = [&](float angle) { return std::cos(angle) * data.spot_cone.x + data.spot_cone.y; };
  EXPECT_EQ(data.spot_direction, glm::vec4(0, 0, -1, 0));
  EXPECT_NEAR(factor(0.3f), 1, 1e-5);
  EXPECT_NEAR(factor(0.6f), 0, 1e-5);
  EXPECT_GT(factor(0.45f), 0.4f);
  EXPECT_LT(factor(0.7f), 0);
}

TEST(FrameDataLight, SpotWithoutSoftEdgeStaysFinite) {
  const gpu::LightData data = light_data({}, spot(0.5f, 0.5f));
  EXPECT_NEAR(data.spot_cone.x, 1000, 1e-2);
  EXPECT_TRUE(std::isfinite(data.spot_cone.y));
}

TEST(MayBeSeen, IsNeverFalseForABoxWithAVisiblePoint) {
  std::mt19937_64 random(21);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
  };
  const auto in_cube = [&](double half) {
    return glm::dvec3(between(-half, half), between(-half, half), between(-half, half));
  };
  int seen = 0, passed_over = 0;
  for (int i = 0; i < kCases; ++i) {
    const View view{{rotation_exp(in_cube(3)), in_cube(4)},
                    {between(-1.2, -0.1), between(0.1, 1.2), between(0.1, 1.2), between(-1.2, -0.1)},
                    kSize};
    const gpu::InstanceData instance =
        instance_data({view, view}, {glm::mat4_cast(rotation_exp(in_cube(2)))});
    const glm::vec3 low(in_cube(6)), high = low + glm::vec3(between(0, 4), between(0, 4), between(0, 4));
    constexpr int steps = 8;
    bool visible = false;
    for (int step = 0; step < steps * steps * steps && !visible; ++step) {
      const glm::vec3 t =
          glm::vec3(step % steps, step / steps % steps, step / steps / steps) / (steps - 1.0f);
      const glm::vec4 p = instance.clip_from_object[0] * glm::vec4(glm::mix(low, high, t), 1.0f);
      visible = p.w > 0 && std::abs(p.x) <= p.w && std::abs(p.y) <= p.w;
    }
    const bool may = may_be_seen(instance, 0, {low, high});
    if (visible) {
      ASSERT_TRUE(may) << "case " << i;
    }
    seen += visible;
    passed_over += !may;
  }
  EXPECT_GT(seen, kCases / 10);
  EXPECT_GT(passed_over, kCases / 4) << "the test leaves out something";
}

TEST(MayBeSeen, IsFalseForAWideBoxBehindTheEye) {
  const View view{{}, {-0.5, 0.5, 0.5, -0.5}, kSize};
  const gpu::InstanceData instance = instance_data({view, view}, {});
  // Its corners are on both sides of each plane of the view's frustum.
  EXPECT_FALSE(may_be_seen(instance, 0, {{-10, -10, 1}, {10, 10, 2}}));
  EXPECT_TRUE(may_be_seen(instance, 0, {{-10, -10, -2}, {10, 10, 2}}));
}

TEST(MayBeSeen, AsksTheEyeThatItIsTold) {
  StereoView views;
  for (View& view : views) view = {{}, {-0.5, 0.5, 0.5, -0.5}, kSize};
  views[1].stage_from_eye.rotation = rotation_exp({0, 3.14, 0});  // looks back
  const gpu::InstanceData instance = instance_data(views, {});
  EXPECT_TRUE(may_be_seen(instance, 0, {{-1, -1, -6}, {1, 1, -5}}));
  EXPECT_FALSE(may_be_seen(instance, 1, {{-1, -1, -6}, {1, 1, -5}}));
}

}  // namespace
}  // namespace farshade
