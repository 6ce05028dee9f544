// Each clause of the definition of a mask bit (stereo/tracer/tracer.h), on scenes whose result is obvious.
// The oracle must agree, too.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/oracle/agreement.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

constexpr std::uint32_t kSide_px = 64;

/// A floor of 8 x 8 m at height 0, seen from above.
const Mesh kFloor = quad({0, 0, 0}, {4, 0, 0}, {0, 0, -4});
const View kFromAbove = look({0.13, 3.0, 2.9}, {0.03, 0.0, -0.1}, kSide_px);

Material sided(bool both) {
  Material material;
  material.double_sided = both;
  return material;
}

/// The share of lit pixel-lights. Expects that the tracer agrees with the oracle.
double lit_share(const Scene& scene, const View& view, double most_in_band = 0.015) {
  const oracle::Agreement sum = expect_agrees(scene, {view, view}, Time{}, most_in_band);
  return static_cast<double>(sum.lit) / static_cast<double>(sum.pixel_lights);
}

TEST(MaskBit, IsSetWhereNothingIsInBetween) {
  SceneBuilder build;
  build.add(kFloor);
  build.point_light({0.5, 2.0, 0.2});
  EXPECT_GT(lit_share(build.build(), kFromAbove), 0.7);
}

TEST(MaskBit, IsZeroWhereNothingIsCovered) {
  SceneBuilder build;
  build.add(kFloor);
  build.point_light({0, 2, 0});
  const View up = look({0, 1, 0}, {0.1, 9, 0}, kSide_px);
  const ShadowFrame frame = traced(build.build(), up);
  EXPECT_EQ(frame.masks[0], EyeMask(up.size, 1));
}

TEST(MaskBit, IsZeroInShadow) {
  SceneBuilder build;
  build.add(kFloor);
  build.add(quad({0, 1, 0}, {4, 0, 0}, {0, 0, 4}));  // hides the whole floor from the light
  build.point_light({0.2, 1.5, 0.1});
  EXPECT_EQ(lit_share(build.build(), look({0, 0.6, 3.5}, {0, 0, 0}, kSide_px, 1.0)), 0.0);
}

TEST(MaskBit, NeedsTheViewersSideOfADoubleSidedSurface) {
  SceneBuilder build;
  build.add(kFloor);
  build.point_light({0.1, -2.0, 0.2});
  const Scene scene = build.build();
  EXPECT_EQ(lit_share(scene, kFromAbove), 0.0);
  EXPECT_GT(lit_share(scene, look({0.13, -3.0, 2.9}, {0.03, 0.0, -0.1}, kSide_px)), 0.7);
}

TEST(MaskBit, NeedsTheShadingNormalToFaceTheLightToo) {
  SceneBuilder build;
  Mesh leaning = kFloor;
  for (glm::vec3& normal : leaning.normals) normal = glm::normalize(glm::vec3(1.0f, 0.2f, 0.0f));
  build.add(leaning);
  build.directional_light({1.0, -1.0, 0.0});
  EXPECT_EQ(lit_share(build.build(), kFromAbove), 0.0);
}

TEST(MaskBit, SingleSidedSurfaceIsSeenThroughFromBehind) {
  const View below = look({0.13, -3.0, 2.9}, {0.03, 0.0, -0.1}, kSide_px);
  SceneBuilder build;
  build.add(kFloor, build.material(sided(false)));
  build.point_light({0.1, -2.0, 0.2});
  EXPECT_EQ(lit_share(build.build(), below), 0.0);
  build.add(quad({0, 1, 0}, {20, 0, 0}, {0, 0, -20}));  // visible through the floor
  EXPECT_NEAR(lit_share(build.build(), below), 0.5, 0.35);
}

TEST(MaskBit, SingleSidedSurfaceCastsFromBothSides) {
  for (const float turn : {1.0f, -1.0f}) {
    SceneBuilder build;
    build.add(kFloor);
    build.add(quad({0, 1, 0}, {4, 0, 0}, {0, 0, 4 * turn}), build.material(sided(false)));
    build.point_light({0.2, 1.5, 0.1});
    EXPECT_EQ(lit_share(build.build(), look({0, 0.6, 3.5}, {0, 0, 0}, kSide_px, 1.0)), 0.0) << turn;
  }
}

TEST(MaskBit, NegativeScaleTurnsTheSeenSideOver) {
  for (const bool moving : {false, true}) {
    SceneBuilder build;
    const auto single = build.material(sided(false));
    const auto mirrored = build.add(kFloor, single, scaled({-1, 1, 1}));
    if (moving) build.move(mirrored, {0, 0, 0.5});
    build.point_light({0.5, 2.0, 0.2});
    const Scene scene = build.build();
    // Mirroring in x keeps the floor's normal up, so that it is still seen from above.
    EXPECT_GT(lit_share(scene, kFromAbove), 0.7) << moving;
    EXPECT_EQ(lit_share(scene, look({0.13, -3.0, 2.9}, {0.03, 0.0, -0.1}, kSide_px)), 0.0) << moving;
  }
}

TEST(MaskBit, HolesAreNeitherSeenNorCast) {
  Texture stripes;
  stripes.image = Image<Rgba8>({4, 4}, Rgba8(255));
  for (std::uint32_t y = 0; y < 4; ++y) stripes.image.at(0, y).a = stripes.image.at(1, y).a = 0;
  for (const Wrap wrap : {Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge}) {
    stripes.wrap_u = stripes.wrap_v = wrap;
    SceneBuilder build;
    Material leaf = sided(wrap == Wrap::Repeat);
    leaf.texture = build.texture(stripes);
    leaf.alpha_cutoff = 0.5f;
    build.add(kFloor);
    Mesh screen = quad({0, 1, 0}, {1, 0, 0}, {0, 0, -1}, 2.5f);
    for (glm::vec2& uv : screen.uvs) uv -= glm::vec2(0.9f);
    screen.colors.assign(screen.positions.size(), glm::u8vec4(255, 255, 255, 220));
    build.add(screen, build.material(leaf));
    build.point_light({0.2, 2.5, 0.1});
    const double with_holes = lit_share(build.build(), kFromAbove);
    SceneBuilder solid;
    solid.add(kFloor);
    solid.add(screen);
    solid.point_light({0.2, 2.5, 0.1});
    EXPECT_GT(with_holes, lit_share(solid.build(), kFromAbove) + 0.02);
  }
}

/// One corner of one triangle is opaque: its quarter of the triangle, an eighth of the floor, is no hole.
TEST(MaskBit, HolesFollowTheAlphaOfEachVertex) {
  const View view = look({0, 4, 0.01}, {0, 0, 0}, 128, 2 * std::atan(0.5));  // sees 4 x 4 m
  for (std::size_t corner = 0; corner < 6; ++corner) {
    SCOPED_TRACE(corner);
    SceneBuilder build;
    Material masked = sided(true);
    masked.alpha_cutoff = 0.5f;
    Mesh floor = quad({0, 0, 0}, {2, 0, 0}, {0, 0, -2});
    floor.colors.assign(6, glm::u8vec4(255, 255, 255, 0));
    floor.colors[corner].a = 255;
    build.add(floor, build.material(masked));
    build.point_light({0.3, 3.0, 0.2});
    EXPECT_NEAR(lit_share(build.build(), view), 0.125, 0.01);
  }
}

/// glTF 2.0, 3.9.4: alpha equal to the cutoff is opaque.
TEST(MaskBit, AlphaEqualToTheCutoffIsNoHole) {
  const auto mask_with = [](std::optional<float> cutoff) {
    SceneBuilder build;
    Material masked = sided(true);
    masked.base_color.a = 0.5f;
    masked.alpha_cutoff = cutoff;
    build.add(kFloor, build.material(masked));
    build.point_light({0.5, 2.0, 0.2});
    return traced(build.build(), kFromAbove).masks[0];
  };
  EXPECT_EQ(mask_with(0.5f), mask_with(std::nullopt));
  EXPECT_EQ(mask_with(0.75f), EyeMask(kFromAbove.size, 1));
}

TEST(MaskBit, EndsAtTheLightsRange) {
  SceneBuilder build;
  build.add(kFloor);
  build.point_light({0, 1, 0}, 1.6f);
  const double share = lit_share(build.build(), look({0, 4, 0.01}, {0, 0, 0}, 128, 2 * std::atan(0.5)));
  const double disc = std::numbers::pi * (1.6 * 1.6 - 1.0) / 16.0;  // of the 4 x 4 m in view
  EXPECT_NEAR(share, disc, 0.01);
}

TEST(MaskBit, EndsAtTheSpotsOuterCone) {
  SceneBuilder build;
  build.add(kFloor);
  build.spot_light({0, 2, 0}, {0, -1, 0}, 0.6f);
  const double share = lit_share(build.build(), look({0, 4, 0.01}, {0, 0, 0}, 128, 2 * std::atan(0.5)));
  EXPECT_NEAR(share, std::numbers::pi * std::pow(2 * std::tan(0.6), 2) / 16.0, 0.01);
}

TEST(MaskBit, FollowsADirectionalLight) {
  SceneBuilder build;
  build.add(kFloor);
  build.add(box({0, 1, 0}, {0.5f, 0.5f, 0.5f}));
  build.directional_light({0.3, -1, 0.2});
  build.directional_light({-0.3, 1, 0.2});  // from below
  const ShadowFrame frame = traced(build.build(), kFromAbove);
  EXPECT_TRUE(frame.masks[0].lit(50, 40, 0));
  EXPECT_FALSE(frame.masks[0].lit(50, 40, 1));
  expect_agrees(build.build(), {kFromAbove, kFromAbove}, Time{}, 0.015);
}

TEST(MaskBit, LightInsideAClosedBoxStaysInside) {
  SceneBuilder build;
  build.add(kFloor);
  build.add(box({0, 1, 0}, {0.5f, 0.5f, 0.5f}));
  build.point_light({0.1, 1.2, 0.1});
  const Scene scene = build.build();
  EXPECT_EQ(lit_share(scene, kFromAbove), 0.0);
  EXPECT_GT(lit_share(scene, look({0.2, 0.8, 0.3}, {-0.4, 1.1, -0.4}, kSide_px)), 0.99);
}

TEST(MaskBit, SurfaceAtTheLightDoesNotCast) {
  SceneBuilder build;
  build.add(kFloor);
  build.add(quad({0, 2, 0}, {1, 0, 0}, {0, 0, 1}));
  build.point_light({0.25, 2.0, 0.5});  // in the plane of the lamp's shade
  EXPECT_GT(lit_share(build.build(), look({0, 1.2, 2}, {0, 0, 0}, kSide_px, 0.8)), 0.9);
}

/// A far light lies in the plane of a shade: rounding of its coordinates must not make the shade cast a
/// shadow.
TEST(MaskBit, SurfaceAtAFarLightDoesNotCast) {
  for (const float far : {300.0f, 3000.0f, 30'000.0f}) {
    SceneBuilder build;
    for (const float x : {-0.3f, -0.1f, 0.1f, 0.3f})  // most vertices are near, and so is the anchor
      build.add(quad({x, 0.003f * x, 0}, {0.1f, 0.0003f, 0}, {0, 0, -0.4f}));
    build.add(quad({3, far, -2}, {1, 0.5f, 0}, {0, 0.25f, 1}));
    build.point_light({3.25, far + 0.125, -2});  // in the plane of the shade
    const View view = look({0.013, 0.3, 0.29}, {0.003, 0.0, -0.01}, 256);
    EXPECT_GT(lit_share(build.build(), view), 0.7) << far;
  }
}

/// The ends of the ray together leave out more than the distance to the light: no ray is left, and nothing
/// casts.
TEST(MaskBit, LightNearerThanTheRaysOffsetsIsSeen) {
  SceneBuilder build;
  build.add(quad({0, 0, 0}, {1000, 0, 0}, {0, 0, -1000}));  // the offset of a ray is 3.8 mm
  build.point_light({0.0002, 0.002, 0.0001});
  const Scene scene = build.build();
  const View view = look({0, 0.01, 0}, {0, 0, 0}, kSide_px);
  for (const ShadowFrame& frame : {traced(scene, view), reference_traced(scene, {view, view})})
    for (std::uint32_t i = 0; i < view.size.pixels(); ++i)
      ASSERT_TRUE(frame.masks[0].lit(i % kSide_px, i / kSide_px, 0)) << i % kSide_px << ", " << i / kSide_px;
}

/// A shading normal that almost lies in the surface would not lift a ray off that surface.
TEST(MaskBit, LeaningShadingNormalLeavesNoSpeckles) {
  SceneBuilder build;
  Mesh leaning = quad({0, 0.013f, 0}, {4, 0.3f, 0.1f}, {0.1f, 0.2f, -4});
  for (glm::vec3& normal : leaning.normals) normal = glm::normalize(normal * 0.01f + glm::vec3(1, 0, 0));
  build.add(leaning);
  build.directional_light({-1.0, -1.0, 0.1});
  build.point_light({9.0, 1.5, 0.3});
  const Scene scene = build.build();
  const oracle::Agreement sum = expect_agrees(scene, {kFromAbove, kFromAbove}, Time{}, 0.015);
  EXPECT_GT(sum.lit * 10, sum.pixel_lights * 7);
}

}  // namespace
}  // namespace farshade
