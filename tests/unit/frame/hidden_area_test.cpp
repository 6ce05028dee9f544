#include "stereo/frame/hidden_area.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <numbers>

namespace farshade {
namespace {

constexpr double kOneDegree = std::numbers::pi / 180;
constexpr double kInner_tan = 0.9, kOuter_tan = 1.6;
constexpr int kRingSides = 64;

glm::dvec2 at(double angle, double radius) {
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

/// What a round lens hides: a ring about the axis.
HiddenArea ring() {
  HiddenArea area;
  for (int i = 0; i < kRingSides; ++i) {
    const double from = 2 * std::numbers::pi * i / kRingSides,
                 to = 2 * std::numbers::pi * (i + 1) / kRingSides;
    for (const glm::dvec2& corner : {at(from, kInner_tan), at(from, kOuter_tan), at(to, kOuter_tan),
                                     at(from, kInner_tan), at(to, kOuter_tan), at(to, kInner_tan)})
      area.corners.emplace_back(corner);
  }
  return area;
}

StereoView views_of(const EyeFov& fov) {
  const View view{{}, fov, {64, 64}};
  return {view, view};
}

const EyeFov kFov{-0.8, 0.8, 0.8, -0.8};

/// The eye turns by `turn` about an axis that lies at `angle` in its picture.
glm::dvec2 turned(const glm::dvec2& corner, double angle, double turn) {
  const glm::dvec3 axis{std::cos(angle), std::sin(angle), 0};
  const glm::dvec3 ray = glm::angleAxis(turn, axis) * glm::dvec3(corner, -1);
  return {ray.x / -ray.z, ray.y / -ray.z};
}

/// The least distance from the axis that a point of the area has after a turn in any direction.
double least_after(const HiddenArea& area, double turn) {
  double least = 10;
  for (const glm::vec2& corner : area.corners)
    for (double angle = 0; angle < 2 * std::numbers::pi; angle += 0.1)
      least = std::min(least, glm::length(turned(glm::dvec2(corner), angle, turn)));
  return least;
}

TEST(HiddenInRequest, IsStillHiddenAfterATurn) {
  const HiddenArea scaled = hidden_in_request({ring(), ring()}, views_of(kFov), views_of(kFov))[1];
  ASSERT_EQ(scaled.corners.size(), ring().corners.size());
  EXPECT_GE(least_after(scaled, kLeastTurn_deg * kOneDegree), kInner_tan * 0.998);
  EXPECT_LT(least_after(scaled, 2 * kLeastTurn_deg * kOneDegree), kInner_tan);
}

TEST(HiddenInRequest, AllowsForTheWidestSideOfTheGuardBand) {
  for (int side = 0; side < 4; ++side) {
    EyeFov wide = kFov;
    (side == 0   ? wide.left_rad
     : side == 1 ? wide.right_rad
     : side == 2 ? wide.up_rad
                 : wide.down_rad) *= 1 + 5 * kOneDegree / 0.8;
    StereoView requested = views_of(kFov);
    requested[0].fov = wide;
    const PerEye<HiddenArea> scaled = hidden_in_request({ring(), ring()}, views_of(kFov), requested);
    EXPECT_GE(least_after(scaled[0], 5 * kOneDegree), kInner_tan * 0.998) << side;
    EXPECT_LT(least_after(scaled[0], 9 * kOneDegree), kInner_tan) << side;
    EXPECT_EQ(scaled[0], scaled[1]) << "the eyes turn together";
  }
}

TEST(HiddenInRequest, IsNoSmallerForWhatLiesFarOutOfTheView) {
  HiddenArea far = ring();
  for (const glm::vec2& corner : {glm::vec2(1, 1), glm::vec2(100, 1), glm::vec2(1, 100)})
    far.corners.push_back(corner);
  const HiddenArea scaled = hidden_in_request({far, far}, views_of(kFov), views_of(kFov))[0];
  EXPECT_EQ(scaled.corners.size(), far.corners.size());
  EXPECT_LT(least_after(scaled, 2 * kLeastTurn_deg * kOneDegree), kInner_tan);
}

TEST(HiddenInRequest, IsNothingIfTheAxisIsHiddenOrTheTurnTooLarge) {
  HiddenArea middle;
  middle.corners = {{-0.1f, -0.1f}, {0.2f, -0.1f}, {-0.1f, 0.2f}};
  EXPECT_EQ(hidden_in_request({middle, ring()}, views_of(kFov), views_of(kFov))[0], HiddenArea{});
  const EyeFov narrow{-0.1, 0.1, 0.1, -0.1}, wide{-1.1, 1.1, 1.1, -1.1};
  EXPECT_EQ(hidden_in_request({ring(), ring()}, views_of(narrow), views_of(wide)), PerEye<HiddenArea>{});
  EXPECT_EQ(hidden_in_request({}, views_of(kFov), views_of(kFov)), PerEye<HiddenArea>{});
}

}  // namespace
}  // namespace farshade
