#include "stereo/draw/mesh_streams.h"

#include <gtest/gtest.h>

#include <cstring>

#include "tests/unit/detail/shapes.h"

namespace farshade {
namespace {

glm::vec3 unfolded(const glm::i16vec2& octahedral) {
  const glm::vec2 p = glm::vec2(octahedral) * (1.0f / 32767);
  glm::vec3 n(p, 1 - std::abs(p.x) - std::abs(p.y));
  const float fold = std::max(-n.z, 0.0f);
  n.x -= n.x < 0 ? -fold : fold;
  n.y -= n.y < 0 ? -fold : fold;
  return glm::normalize(n);
}

std::uint32_t index_at(const MeshStreams& streams, std::size_t bytes, std::size_t i) {
  std::uint32_t index = 0;
  std::memcpy(&index, &streams.indices[i * bytes], bytes);
  return index;
}

/// Every corner of every level has the position, the normal and the texture coordinates of the mesh's vertex.
void expect_the_same_corners(const Mesh& mesh, const MeshLevels& levels) {
  const MeshStreams streams = make_streams(mesh, {.texture = true}, levels);
  const std::size_t bytes = index_bytes(mesh.positions.size());
  ASSERT_EQ(streams.ranges.size(), levels.levels.size() + 1);
  for (std::size_t level = 0; level < streams.ranges.size(); ++level) {
    const IndexRange& range = streams.ranges[level];
    const glm::uvec3* triangles =
        level == 0 ? mesh.triangles.data() : &levels.triangles[levels.levels[level - 1].first];
    ASSERT_EQ(range.count, 3 * (level == 0 ? mesh.triangles.size() : levels.levels[level - 1].count));
    for (std::size_t i = 0; i < range.count; ++i) {
      const std::uint32_t vertex = triangles[i / 3][static_cast<glm::length_t>(i % 3)],
                          there = index_at(streams, bytes, range.first + i);
      ASSERT_LT(there, range.vertices) << "a level reads only its first vertices";
      ASSERT_EQ(streams.positions[there], mesh.positions[vertex]);
      ASSERT_LT(glm::length(unfolded(streams.normals[there]) - mesh.normals[vertex]), 1e-4f);
      ASSERT_EQ(streams.uvs[there], mesh.uvs.empty() ? glm::vec2(0) : mesh.uvs[vertex]);
    }
  }
}

TEST(MeshStreams, HaveTheCornersOfAllLevels) {
  const Mesh sphere = bumpy_sphere(1);
  expect_the_same_corners(sphere, make_levels(sphere));
  const Mesh flat = grid_mesh(40, 40, [](float u, float v) { return glm::vec3(u, 0, v); });
  expect_the_same_corners(flat, make_levels(flat));
  expect_the_same_corners(sphere, {});
}

TEST(MeshStreams, TakeWideIndicesOnlyForManyVertices) {
  const Mesh large = grid_mesh(300, 300, [](float u, float v) { return glm::vec3(u, 0, v); });
  EXPECT_EQ(index_bytes(large.positions.size()), 4u);
  expect_the_same_corners(large, {});
  EXPECT_EQ(index_bytes(65536), 2u);
  EXPECT_EQ(index_bytes(65537), 4u);
}

TEST(MeshStreams, HaveTheSizesThatAreStated) {
  const Mesh mesh = bumpy_sphere(2);
  const MeshLevels levels = make_levels(mesh);
  for (const SurfaceNeeds needs : {SurfaceNeeds{}, SurfaceNeeds{.texture = true, .vertex_color = true}}) {
    const MeshStreams streams = make_streams(mesh, needs, levels);
    const StreamBytes bytes = stream_bytes(mesh, needs, levels);
    EXPECT_EQ(bytes.positions, std::as_bytes(std::span(streams.positions)).size());
    EXPECT_EQ(bytes.normals, std::as_bytes(std::span(streams.normals)).size());
    EXPECT_EQ(bytes.uvs, std::as_bytes(std::span(streams.uvs)).size());
    EXPECT_EQ(bytes.colors, std::as_bytes(std::span(streams.colors)).size());
    EXPECT_EQ(bytes.indices, streams.indices.size());
  }
}

// A coarse level reads a compact part of the vertices.
TEST(MeshStreams, PutTheVerticesOfTheCoarsestLevelFirst) {
  const Mesh mesh = bumpy_sphere(3);
  const MeshStreams streams = make_streams(mesh, {}, make_levels(mesh));
  ASSERT_GE(streams.ranges.size(), 4u);
  for (std::size_t level = 2; level < streams.ranges.size(); ++level)
    EXPECT_LT(streams.ranges[level].vertices, streams.ranges[level - 1].vertices);
  EXPECT_LT(streams.ranges.back().vertices, mesh.positions.size() / 8);
}

TEST(MeshStreams, AreRelativeToTheCentreOfAFarMesh) {
  Mesh far = bumpy_sphere(4);
  for (glm::vec3& p : far.positions) p += glm::vec3(1000, 0, 0);
  const MeshStreams streams = make_streams(far, {}, {});
  EXPECT_NEAR(streams.center.x, 1000, 1);
  for (const glm::vec3& p : streams.positions) EXPECT_LT(glm::length(p), 2);
  EXPECT_EQ(make_streams(bumpy_sphere(4), {}, {}).center, glm::dvec3(0));
}

}  // namespace
}  // namespace farshade
