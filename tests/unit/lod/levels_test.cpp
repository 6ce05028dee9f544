// Levels of detail: their error bound against the full mesh, measured at other points than the library's;
// seams; attributes; triangle counts.
#include "stereo/lod/levels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>

#include "stereo/gltf/gltf.h"
#include "stereo/lod/surface_distance.h"
#include "tests/support/sanitized.h"
#include "tests/unit/lod/shapes.h"

namespace farshade {
namespace {

std::span<const glm::uvec3> triangles_of(const MeshLevels& levels, const DetailLevel& level) {
  return std::span(levels.triangles).subspan(level.first, level.count);
}

/// The largest distance from random points of one surface to the other surface.
float one_sided(std::span<const glm::vec3> positions, std::span<const glm::uvec3> from,
                std::span<const glm::uvec3> to, std::mt19937& random) {
  const SurfaceDistance surface(positions, to);
  std::uniform_real_distribution<float> unit(0, 1);
  const std::size_t per_triangle = std::max<std::size_t>(6, 4000 / from.size());
  float worst = 0;
  for (const glm::uvec3& t : from)
    for (std::size_t i = 0; i < per_triangle; ++i) {
      float u = unit(random), v = unit(random);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const glm::vec3 p = positions[t.x] * (1 - u - v) + positions[t.y] * u + positions[t.z] * v;
      worst = std::max(worst, surface.distance_above(p, worst, 1e-3f));
    }
  return worst;
}

/// The sampled Hausdorff distance of each level is within its bound.
void expect_bounds_hold(const Mesh& mesh, const std::string& name) {
  const MeshLevels levels = make_levels(mesh);
  std::mt19937 random(7);
  for (const DetailLevel& level : levels.levels) {
    const auto coarse = triangles_of(levels, level);
    const float distance = std::max(one_sided(mesh.positions, mesh.triangles, coarse, random),
                                    one_sided(mesh.positions, coarse, mesh.triangles, random));
    EXPECT_LE(distance, level.error) << name << ", level of " << level.count << " triangles";
  }
}

TEST(DetailLevels, StayWithinTheirErrorOnRandomMeshes) {
  for (std::uint32_t seed = 1; seed <= (kSanitized ? 3 : 10); ++seed) {
    expect_bounds_hold(bumpy_sphere(seed), "sphere " + std::to_string(seed));
    expect_bounds_hold(terrain(seed), "terrain " + std::to_string(seed));
    expect_bounds_hold(faceted(bumpy_sphere(seed)), "faceted sphere " + std::to_string(seed));
  }
  expect_bounds_hold(pole(), "pole");
}

TEST(DetailLevels, StayWithinTheirErrorInTheBundledScenes) {
  for (const char* file : {"room.glb", "gallery.glb"}) {
    const Expected<Scene> scene = load_scene(std::filesystem::path(FARSHADE_ASSETS) / file);
    if (!scene) continue;
    std::size_t levels = 0;
    for (const Mesh& mesh : scene->meshes) {
      expect_bounds_hold(mesh, mesh.name);
      levels += make_levels(mesh).levels.size();
    }
    EXPECT_GT(levels, 20u) << file;
  }
}

TEST(DetailLevels, AreCoarserAndCoarser) {
  const Mesh mesh = bumpy_sphere(3);
  const MeshLevels levels = make_levels(mesh);
  ASSERT_GE(levels.levels.size(), 4u);
  std::size_t before = mesh.triangles.size();
  float error = 0;
  for (const DetailLevel& level : levels.levels) {
    EXPECT_LT(level.count, 0.86 * static_cast<double>(before));
    EXPECT_GE(level.error, error);
    before = level.count;
    error = level.error;
  }
  EXPECT_GT(levels.levels.front().error, 0);
}

TEST(DetailLevels, OfAFlatMeshKeepAlmostNothingAndHaveNoError) {
  const Mesh flat = grid_mesh(32, 32, [](float u, float v) { return glm::vec3(u, 0, v); });
  const MeshLevels levels = make_levels(flat);
  ASSERT_FALSE(levels.levels.empty());
  EXPECT_LE(levels.levels.back().count, 32u);
  EXPECT_LT(levels.levels.back().error, 1e-5f);
}

// A texture whose coordinates bend on a flat mesh needs its vertices.
TEST(DetailLevels, CountTextureCoordinatesAsDistance) {
  Mesh flat = grid_mesh(32, 32, [](float u, float v) { return glm::vec3(u, 0, v); });
  for (glm::vec2& uv : flat.uvs) uv.x += 0.1f * std::sin(9 * uv.x);
  const MeshLevels levels = make_levels(flat);
  for (const DetailLevel& level : levels.levels) {
    if (level.count < 100) {
      EXPECT_GT(level.error, 1e-3f);
    }
  }
}

TEST(DetailLevels, CountColorsAsDistance) {
  Mesh flat = grid_mesh(32, 32, [](float u, float v) { return glm::vec3(u, 0, v); });
  for (const glm::vec2& uv : flat.uvs)
    flat.colors.emplace_back(static_cast<std::uint8_t>(127 + 120 * std::sin(20 * uv.x)), 0, 0, 255);
  const MeshLevels levels = make_levels(flat);
  for (const DetailLevel& level : levels.levels) {
    if (level.count < 200) {
      EXPECT_GT(level.error, 1e-3f);
    }
  }
}

// The large flat faces of a box with rounded edges must not take over the normals of the rounding.
TEST(DetailLevels, KeepTheNormalsOfLargeFlatFaces) {
  const float edge = 0.02f;
  const Mesh rounded = grid_mesh(34, 1, [&](float u, float v) {
    const float t = std::clamp((u * 34 - 1) / 32, 0.0f, 1.0f) * std::numbers::pi_v<float> / 2;
    const float flat_x = u * 34 < 1 ? u * 34 - 1 : 0, flat_y = u * 34 > 33 ? u * 34 - 33 : 0;
    return glm::vec3(flat_x + edge * std::sin(t), edge * std::cos(t) - flat_y, v);
  });
  const MeshLevels levels = make_levels(rounded);
  for (const DetailLevel& level : levels.levels) {
    for (const glm::uvec3& t : triangles_of(levels, level)) {
      const glm::vec3 a = rounded.positions[t.x], b = rounded.positions[t.y], c = rounded.positions[t.z];
      const glm::vec3 across = glm::cross(b - a, c - a);
      if (glm::length(across) < 0.1f) continue;
      for (const std::uint32_t corner : {t.x, t.y, t.z}) {
        EXPECT_TRUE(level.error > 0.1f || glm::dot(glm::normalize(across), rounded.normals[corner]) > 0.95f)
            << "level of " << level.count << " triangles";
      }
    }
  }
}

// Vertices that differ by a hard edge stay apart: each triangle of a level has normals of one side.
TEST(DetailLevels, KeepHardEdges) {
  Mesh folded = grid_mesh(32, 32, [](float u, float v) { return glm::vec3(u, std::abs(u - 0.5f), v); });
  // Its fold gets two normals for each vertex: the grid's own columns on both sides of u = 0.5.
  const float slope = std::sqrt(0.5f);
  std::vector<std::uint32_t> twin(folded.positions.size());
  const std::size_t count = folded.positions.size();
  for (std::size_t i = 0; i < count; ++i) {
    const float u = folded.positions[i].x;
    folded.normals[i] = glm::vec3(u <= 0.5f ? slope : -slope, slope, 0);
    if (u != 0.5f) continue;
    twin[i] = static_cast<std::uint32_t>(folded.positions.size());
    folded.positions.push_back(glm::vec3(folded.positions[i]));
    folded.normals.emplace_back(-slope, slope, 0);
    folded.uvs.push_back(glm::vec2(folded.uvs[i]));
  }
  for (glm::uvec3& t : folded.triangles) {
    const float middle = (folded.positions[t.x].x + folded.positions[t.y].x + folded.positions[t.z].x) / 3;
    for (glm::length_t corner = 0; corner < 3; ++corner)
      if (middle > 0.5f && folded.positions[t[corner]].x == 0.5f) t[corner] = twin[t[corner]];
  }
  const MeshLevels levels = make_levels(folded);
  ASSERT_FALSE(levels.levels.empty());
  for (const glm::uvec3& t : levels.triangles) {
    EXPECT_EQ(folded.normals[t.x], folded.normals[t.y]);
    EXPECT_EQ(folded.normals[t.x], folded.normals[t.z]);
  }
  EXPECT_LE(levels.levels.back().count, folded.triangles.size() / 4);
}

TEST(DetailLevels, AreMadeOfTheMeshesOwnVertices) {
  const Mesh mesh = faceted(bumpy_sphere(1));
  const MeshLevels levels = make_levels(mesh);
  ASSERT_FALSE(levels.levels.empty())
      << "a finely faceted mesh is simplified although every facet has a normal";
  for (const glm::uvec3& t : levels.triangles) EXPECT_LT(std::max({t.x, t.y, t.z}), mesh.positions.size());
}

TEST(DetailLevels, OfBrokenMeshesAreNone) {
  EXPECT_TRUE(make_levels(Mesh{}).levels.empty());
  Mesh point = grid_mesh(16, 16, [](float, float) { return glm::vec3(1, 2, 3); });
  EXPECT_TRUE(make_levels(point).levels.empty()) << "all triangles are points";
  Mesh line = grid_mesh(16, 16, [](float u, float) { return glm::vec3(u, 0, 0); });
  for (const DetailLevel& level : make_levels(line).levels) EXPECT_TRUE(std::isfinite(level.error));
}

TEST(DetailLevels, AreTheSameOnEveryCall) {
  const Mesh mesh = bumpy_sphere(2);
  const MeshLevels a = make_levels(mesh), b = make_levels(mesh);
  EXPECT_EQ(a.triangles, b.triangles);
}

}  // namespace
}  // namespace farshade
