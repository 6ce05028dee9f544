#include "stereo/edge_rays/caster_texels.h"

#include <gtest/gtest.h>

#include "shaders/edge_rays_data.h"

namespace farshade {
namespace {

constexpr std::size_t kMost = 1'000'000;

/// Texture i has i + 1 columns, two rows, and alphas of 100 * i + 1 and so on.
Scene scene_with_textures(std::uint32_t count) {
  Scene scene;
  for (std::uint32_t i = 0; i < count; ++i) {
    Texture texture{
        .image = Image<Rgba8>({i + 1, 2}), .wrap_u = Wrap::MirroredRepeat, .wrap_v = Wrap::ClampToEdge};
    auto alpha = static_cast<std::uint8_t>(100 * i);
    for (Rgba8& pixel : texture.image.pixels) pixel = Rgba8(7, 7, 7, ++alpha);
    scene.textures.push_back(texture);
  }
  return scene;
}

std::array<glm::vec3, 3> corners_at(float x) {
  return {{{x, 1, 2}, {x, 3, 4}, {x, 5, 6}}};
}

/// An opaque triangle between two of texture 1, then one with holes and no texture.
CasterTriangles casters() {
  const TriangleAlpha leaf{
      .cutoff = 0.5f, .at_corners = {1, 2, 3}, .texture = 1, .uvs = {{{4, 5}, {6, 7}, {8, 9}}}};
  const TriangleAlpha plain{.cutoff = 0.25f, .at_corners = {0.1f, 0.2f, 0.3f}, .texture = {}, .uvs = {}};
  return {.origin = {},
          .corners = {corners_at(10), corners_at(20), corners_at(30), corners_at(40)},
          .has_holes = {true, false, true, true},
          .alphas = {leaf, leaf, plain}};
}

const glm::vec4& at(const CasterTexels& texels, float index) {
  return texels.triangles.at(static_cast<std::size_t>(index));
}

TEST(CasterTexels, BeginWithTheCornersOfAllTriangles) {
  const CasterTexels texels = caster_texels(scene_with_textures(2), casters(), kMost, kMost);
  for (std::size_t t = 0; t < 4; ++t)
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_EQ(glm::vec3(texels.triangles.at(3 * t + c)), casters().corners[t][c]);
  EXPECT_EQ(texels.triangles[3].w, 0.0f) << "it has no holes";
}

TEST(CasterTexels, NameTheAlphaOfTrianglesWithHoles) {
  const CasterTexels texels = caster_texels(scene_with_textures(2), casters(), kMost, kMost);
  for (const std::size_t triangle : {0u, 2u}) {
    const float index = texels.triangles[3 * triangle].w;
    ASSERT_GE(index, 12.0f);
    EXPECT_EQ(at(texels, index), glm::vec4(1, 2, 3, 0.5f));
    EXPECT_EQ(at(texels, index + 1), glm::vec4(4, 5, 6, 7));
    EXPECT_EQ(glm::vec2(at(texels, index + 2)), glm::vec2(8, 9));
  }
  EXPECT_EQ(at(texels, texels.triangles[9].w), glm::vec4(0.1f, 0.2f, 0.3f, 0.25f));
}

TEST(CasterTexels, HoldEachTextureInUseOnceAndAnOpaqueTexel) {
  const CasterTexels texels = caster_texels(scene_with_textures(3), casters(), kMost, kMost);
  EXPECT_EQ(texels.alphas, (std::vector<std::uint8_t>{255, 101, 102, 103, 104}));
  EXPECT_EQ(texels.triangles.size(), 3u * (4 + 3) + 2);
  EXPECT_EQ(texels.bytes(), texels.triangles.size() * 16 + 5);
  const auto texture_of = [&](std::size_t triangle) {
    return at(texels, at(texels, texels.triangles[3 * triangle].w + 2).z);
  };
  EXPECT_EQ(texture_of(0), glm::vec4(1, 2, 2, FARSHADE_WRAP_MIRRORED + 4 * FARSHADE_WRAP_CLAMPED));
  EXPECT_EQ(texture_of(2), texture_of(0));
  EXPECT_EQ(texture_of(3), glm::vec4(0, 1, 1, 0)) << "the opaque texel";
}

TEST(CasterTexels, DoNotKnowHolesThatDoNotFit) {
  const Scene scene = scene_with_textures(2);
  const CasterTexels all = caster_texels(scene, casters(), kMost, kMost);
  const std::size_t bytes = all.bytes(), most_texels = all.triangles.size();
  EXPECT_EQ(caster_texels(scene, casters(), bytes, most_texels).triangles, all.triangles);
  for (const CasterTexels& texels : {caster_texels(scene, casters(), bytes - 1, most_texels),
                                     caster_texels(scene, casters(), bytes, most_texels - 1)}) {
    EXPECT_EQ(texels.triangles.size(), 3u * 4 + 1);
    EXPECT_EQ(texels.alphas, std::vector<std::uint8_t>{255});
    for (const std::size_t triangle : {0u, 2u, 3u})
      EXPECT_EQ(texels.triangles[3 * triangle].w, FARSHADE_UNKNOWN_HOLES);
    EXPECT_EQ(texels.triangles[3].w, 0.0f);
  }
}

TEST(CasterTexels, DoNotKnowHolesOfMoreAlphasThanAFloatCounts) {
  Scene scene = scene_with_textures(2);
  scene.textures[1].image = Image<Rgba8>({4096, 4096});
  EXPECT_EQ(caster_texels(scene, casters(), 100 * kMost, 100 * kMost).triangles[0].w, FARSHADE_UNKNOWN_HOLES);
}

TEST(CasterTexels, AreNeverEmpty) {
  const CasterTexels texels = caster_texels({}, {}, 0, 0);
  EXPECT_FALSE(texels.triangles.empty());
  EXPECT_FALSE(texels.alphas.empty());
}

}  // namespace
}  // namespace farshade
