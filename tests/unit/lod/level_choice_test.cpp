#include "stereo/lod/level_choice.h"

#include <gtest/gtest.h>

#include <array>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "stereo/math/fov.h"
#include "tests/support/sanitized.h"

namespace farshade {
namespace {

constexpr Extent kView{640, 480};

glm::dmat4 window() {
  return clip_from_eye({-1.2, 0.9, 0.8, -1.0});
}

glm::dvec2 pixel_of(const glm::dmat4& clip, const glm::dvec3& p) {
  const glm::dvec4 at = clip * glm::dvec4(p, 1.0);
  return (glm::dvec2(at) / at.w * 0.5 + 0.5) * glm::dvec2(kView.width, kView.height);
}

/// The largest pixels per unit of small movements of random visible points of a box; 0 if none is visible.
double sampled(const glm::dmat4& clip, const Bounds& box, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  double most = 0;
  for (int i = 0; i < 20000; ++i) {
    const glm::dvec3 p = glm::mix(box.low, box.high, glm::dvec3(unit(random), unit(random), unit(random)));
    const glm::dvec4 at = clip * glm::dvec4(p, 1.0);
    if (!(at.w > 0) || std::abs(at.x) > at.w || std::abs(at.y) > at.w) continue;
    glm::dvec3 direction(unit(random) - 0.5, unit(random) - 0.5, unit(random) - 0.5);
    direction *= 1e-6 * at.w / glm::length(direction);
    most = std::max(most,
                    glm::length(pixel_of(clip, p + direction) - pixel_of(clip, p)) / glm::length(direction));
  }
  return most;
}

TEST(LevelChoice, BoundsThePixelsThatAnErrorMovesAPoint) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  int seen = 0, tight = 0;
  constexpr int kTrials = kSanitized ? 60 : 300;
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto vector = [&] { return glm::dvec3(unit(random), unit(random), unit(random)); };
    glm::dmat4 object = glm::translate(glm::dmat4(1.0), 4.0 * vector() + glm::dvec3(0, 0, -2));
    object = glm::rotate(object, 3 * unit(random), glm::normalize(vector()));
    glm::dvec3 scale = glm::abs(vector()) + 0.05;
    if (trial % 3 == 0) scale.x = -scale.x;  // mirrored
    object = glm::scale(object, scale);
    const glm::dvec3 a = vector(), b = vector();
    const Bounds box{glm::min(a, b), glm::max(a, b)};
    const glm::dmat4 clip = window() * object;
    const double measured = sampled(clip, box, random), bound = pixels_per_unit(clip, box, kView);
    if (measured == 0) continue;
    ++seen;
    EXPECT_LE(measured, bound * 1.0001) << "trial " << trial;
    tight += bound < 3 * measured;
  }
  EXPECT_GT(seen, kTrials / 3);
  EXPECT_GT(tight, seen / 2) << "a bound that is always much too large saves no triangles";
}

TEST(LevelChoice, OfABoxAroundTheEyeIsFullDetail) {
  const Bounds box{glm::dvec3(-1), glm::dvec3(1)};
  EXPECT_TRUE(std::isinf(pixels_per_unit(window(), box, kView)));
  EXPECT_FALSE(
      std::isinf(pixels_per_unit(window() * glm::translate(glm::dmat4(1), {0, 0, -3.0}), box, kView)));
}

TEST(LevelChoice, BoundsABoxThatReachesBehindTheEye) {
  std::mt19937 random(5);
  for (const Bounds& beside : {Bounds{{1, -1, -4}, {2, 1, 4}}, Bounds{{-2, -1, -4}, {-1, 1, 4}},
                               Bounds{{-1, 1, -4}, {1, 2, 4}}, Bounds{{-1, -2, -4}, {1, -1, 4}}}) {
    const double bound = pixels_per_unit(window(), beside, kView);
    const double measured = sampled(window(), beside, random);
    EXPECT_LE(measured, bound * 1.0001) << beside.low.x << ", " << beside.low.y;
    EXPECT_LT(bound, 3 * measured) << beside.low.x << ", " << beside.low.y;
  }
}

TEST(LevelChoice, OfASingularInstanceIsFinite) {
  const glm::dmat4 flat = glm::scale(glm::translate(glm::dmat4(1), {0, 0, -3.0}), {1.0, 1e-9, 1.0});
  const double bound = pixels_per_unit(window() * flat, {glm::dvec3(-1), glm::dvec3(1)}, kView);
  EXPECT_TRUE(std::isfinite(bound));
  EXPECT_GT(bound, 0);
}

TEST(LevelChoice, OfAParallelProjectionIsItsScale) {
  glm::dmat4 parallel(1.0);
  parallel[0][0] = 0.5, parallel[1][1] = 0.5;
  const double bound = pixels_per_unit(parallel, {glm::dvec3(-1), glm::dvec3(1)}, {100, 100});
  EXPECT_NEAR(bound, 25, 1e-9);
}

constexpr std::array<DetailLevel, 3> kLevels{{{0, 100, 0.1f}, {100, 50, 0.2f}, {150, 25, 0.4f}}};

TEST(LevelChoice, TakesTheCoarsestLevelWithinTheLimit) {
  EXPECT_EQ(choose_level(kLevels, 10, 0.5, 0), 0u);
  EXPECT_EQ(choose_level(kLevels, 1, 0.15, 0), 1u);
  EXPECT_EQ(choose_level(kLevels, 1, 0.3, 0), 2u);
  EXPECT_EQ(choose_level(kLevels, 1, 10, 0), 3u);
  EXPECT_EQ(choose_level({}, 1, 10, 0), 0u);
  EXPECT_EQ(choose_level(kLevels, 1, double{kLevels[1].error}, 2), 2u) << "at most the limit";
}

TEST(LevelChoice, KeepsALevelWhileItIsWithinTheLimit) {
  // The error of level 2 is 0.2 units: coarser only below kHysteresis of the limit, finer only above the
  // limit.
  const double limit = 0.21;
  EXPECT_EQ(choose_level(kLevels, 1, limit, 0), 1u) << "not yet";
  EXPECT_EQ(choose_level(kLevels, 1, limit, 1), 1u) << "not yet from the next finer level either";
  EXPECT_EQ(choose_level(kLevels, 1, limit, 2), 2u) << "still";
  EXPECT_EQ(choose_level(kLevels, 1.1, limit, 2), 1u) << "no longer";
  EXPECT_EQ(choose_level(kLevels, 0.7, limit, 0), 2u) << "now";
  for (std::uint32_t previous = 0; previous <= 3; ++previous) {
    const std::uint32_t level = choose_level(kLevels, 1, limit, previous);
    EXPECT_TRUE(level == 0 || double{kLevels[level - 1].error} <= limit) << "the limit always holds";
  }
}

}  // namespace
}  // namespace farshade
