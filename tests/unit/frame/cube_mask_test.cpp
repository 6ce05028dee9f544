// The faces of the cube mask.
#include "stereo/frame/cube_mask.h"

#include <gtest/gtest.h>

#include <random>

#include "stereo/frame/tiles.h"

namespace farshade {
namespace {

constexpr Point<Stage> kCentre{{3, -2, 1000}};

/// Whether the four pixels around a direction are in the face.
bool has_pixels_around(const View& face, const glm::dvec3& direction) {
  const glm::dvec3 seen = glm::conjugate(face.stage_from_eye.rotation) * direction;
  if (seen.z >= 0) return false;
  const glm::dvec2 at = ray_pixel(tangents_of(face.fov), face.size, seen);
  return at.x >= 0.5 && at.y >= 0.5 && at.x < face.size.width - 0.5 && at.y < face.size.height - 0.5;
}

TEST(CubeMask, TheFourPixelsAroundEveryDirectionAreInOneFace) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  for (const std::uint32_t side : {16u, 64u, 288u})
    for (int i = 0; i < 5000; ++i) {
      glm::dvec3 direction(normal(random), normal(random), normal(random));
      if (i % 3 == 0) direction.x = direction.y;  // on the edge of two faces
      if (i % 6 == 0) direction.z = -direction.y;
      int faces = 0;
      for (std::size_t pair = 0; pair < kCubeMaskPairs; ++pair)
        for (const View& face : faces_about(kCentre, pair, {side, side}))
          faces += has_pixels_around(face, direction);
      EXPECT_GE(faces, 1) << direction.x << ' ' << direction.y << ' ' << direction.z;
    }
}

TEST(CubeMask, PairsLookAlongTheAxesOfTheStage) {
  for (std::size_t pair = 0; pair < kCubeMaskPairs; ++pair) {
    const StereoView faces = faces_about(kCentre, pair, {32, 32});
    for (std::size_t i = 0; i < kEyes; ++i) {
      glm::dvec3 axis(0);
      axis[static_cast<int>(pair)] = i == 0 ? 1 : -1;
      EXPECT_LT(glm::length(faces[i].stage_from_eye.rotation * glm::dvec3(0, 0, -1) - axis), 1e-12);
      EXPECT_EQ(faces[i].stage_from_eye.translation, kCentre.v);
      EXPECT_TRUE(is_valid(faces[i]));
    }
  }
}

TEST(CubeMask, AWholeOneHasAtMostTwiceThePixelsOfBothViews) {
  for (const Extent size : {Extent{128, 128}, {256, 256}, {640, 480}, {600, 600}}) {
    const Extent face = face_size(size);
    EXPECT_EQ(face.width % kTileSide_px, 0u);
    EXPECT_LE(kCubeMaskPairs * kEyes * face.pixels(), 2 * kEyes * size.pixels());
    EXPECT_GE(kCubeMaskPairs * kEyes * face.pixels(), 3 * kEyes * size.pixels() / 2);
  }
  EXPECT_EQ(face_size({1, 1}), (Extent{kLeastFace_px, kLeastFace_px}));
  EXPECT_EQ(face_size({8192, 8192}), (Extent{kMostFace_px, kMostFace_px}));
}

TEST(CubeMask, EachRequestOfThreeHasItsPair) {
  for (std::uint32_t i = 0; i < 7; ++i)
    EXPECT_EQ(pair_of({kFirstCubeMaskFrame.value + i}), i % kCubeMaskPairs);
}

}  // namespace
}  // namespace farshade
