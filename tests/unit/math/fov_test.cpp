#include "stereo/math/fov.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace farshade {
namespace {

constexpr double degrees(double angle) {
  return angle * std::numbers::pi / 180.0;
}
constexpr EyeFov fov_of_degrees(double left, double right, double up, double down) {
  return {degrees(left), degrees(right), degrees(up), degrees(down)};
}

constexpr Extent kSize{640, 480};

class Fovs : public testing::TestWithParam<EyeFov> {
 protected:
  const FovTangents window = tangents_of(GetParam());
};

TEST_P(Fovs, AreValid) {
  EXPECT_TRUE(is_valid(GetParam()));
}

TEST_P(Fovs, CornersLookAlongTheFourAngles) {
  const glm::dvec3 top_left = pixel_ray(window, kSize, {0, 0});
  const glm::dvec3 bottom_right = pixel_ray(window, kSize, {kSize.width, kSize.height});
  EXPECT_NEAR(std::atan2(top_left.x, -top_left.z), GetParam().left_rad, 1e-14);
  EXPECT_NEAR(std::atan2(top_left.y, -top_left.z), GetParam().up_rad, 1e-14);
  EXPECT_NEAR(std::atan2(bottom_right.x, -bottom_right.z), GetParam().right_rad, 1e-14);
  EXPECT_NEAR(std::atan2(bottom_right.y, -bottom_right.z), GetParam().down_rad, 1e-14);
}

TEST_P(Fovs, RayPixelInvertsPixelRayAtAnyDistance) {
  for (const glm::dvec2 pixel : {glm::dvec2(0.5, 0.5), glm::dvec2(639.5, 479.5), glm::dvec2(100.25, 300.75)})
    for (const double distance : {1e-3, 1.0, 1e4}) {
      const glm::dvec2 back = ray_pixel(window, kSize, distance * pixel_ray(window, kSize, pixel));
      EXPECT_LE(glm::length(back - pixel), 1e-9) << pixel.x << ", " << pixel.y;
    }
}

TEST_P(Fovs, ProjectionAgreesWithRayPixel) {
  for (const glm::dvec2 pixel :
       {glm::dvec2(0.5, 0.5), glm::dvec2(639.5, 479.5), glm::dvec2(100.25, 300.75)}) {
    const double distance = 3.0;
    const glm::dvec4 clip =
        clip_from_eye(window) * glm::dvec4(distance * pixel_ray(window, kSize, pixel), 1.0);
    EXPECT_NEAR((clip.x / clip.w + 1) / 2 * kSize.width, pixel.x, 1e-9);
    EXPECT_NEAR((clip.y / clip.w + 1) / 2 * kSize.height, pixel.y, 1e-9);
    EXPECT_DOUBLE_EQ(clip.z / clip.w, kNearPlane_m / distance);
  }
}

INSTANTIATE_TEST_SUITE_P(OneTo170Degrees, Fovs,
                         testing::Values(fov_of_degrees(-45, 45, 45, -45), fov_of_degrees(-54, 40, 44, -55),
                                         fov_of_degrees(-0.5, 0.5, 0.5, -0.5),
                                         fov_of_degrees(-85, 85, 85, -85), fov_of_degrees(10, 30, -5, -40)));

TEST(ClipFromEye, PutsNearPlaneAtOneAndInfinityAtZero) {
  const glm::dmat4 m = clip_from_eye(tangents_of(fov_of_degrees(-45, 45, 45, -45)));
  const glm::dvec4 near_point = m * glm::dvec4(0, 0, -kNearPlane_m, 1),
                   infinity = m * glm::dvec4(0, 0, -1, 0);
  EXPECT_DOUBLE_EQ(near_point.z / near_point.w, 1.0);
  EXPECT_DOUBLE_EQ(infinity.z / infinity.w, 0.0);
}

TEST(PixelRay, CentreOfASymmetricEyeLooksAhead) {
  const glm::dvec3 ahead = pixel_ray(tangents_of(fov_of_degrees(-30, 30, 20, -20)), kSize, {320, 240});
  EXPECT_LE(glm::length(ahead - glm::dvec3(0, 0, -1)), 1e-15);
}

TEST(FovIsValid, RefusesAnglesThatAreNoWindow) {
  const EyeFov good = fov_of_degrees(-45, 45, 45, -45);
  const auto with = [&](double EyeFov::*angle, double value) {
    EyeFov fov = good;
    fov.*angle = value;
    return fov;
  };
  EXPECT_FALSE(is_valid(with(&EyeFov::left_rad, degrees(45))));   // no width
  EXPECT_FALSE(is_valid(with(&EyeFov::left_rad, degrees(50))));   // left angle beyond the right one
  EXPECT_FALSE(is_valid(with(&EyeFov::down_rad, degrees(45))));   // no height
  EXPECT_FALSE(is_valid(with(&EyeFov::up_rad, degrees(-50))));    // upside down
  EXPECT_FALSE(is_valid(with(&EyeFov::right_rad, degrees(90))));  // no tangent
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    for (const auto angle : {&EyeFov::left_rad, &EyeFov::right_rad, &EyeFov::up_rad, &EyeFov::down_rad})
      EXPECT_FALSE(is_valid(with(angle, bad)));
}

}  // namespace
}  // namespace farshade
