#include "stereo/raster/mesh_streams.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <random>
#include <tuple>

#include "tests/unit/lod/shapes.h"

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

/// A triangle's corners: position and texture coordinates, then the normal. The least corner is the first.
struct Corners {
  std::array<std::array<float, 5>, 3> exact{};
  std::array<glm::vec3, 3> normals{};
  bool operator<(const Corners& other) const { return exact < other.exact; }
};

Corners from_least(const Corners& corners) {
  const auto least = std::min_element(corners.exact.begin(), corners.exact.end()) - corners.exact.begin();
  Corners result = corners;
  std::rotate(result.exact.begin(), result.exact.begin() + least, result.exact.end());
  std::rotate(result.normals.begin(), result.normals.begin() + least, result.normals.end());
  return result;
}

/// The sorted triangles of a range. `vertex(i)` is that of index i; `at` returns its exact part and normal.
template <class Vertex, class At>
std::vector<Corners> sorted_corners(std::size_t indices, const Vertex& vertex, const At& at) {
  std::vector<Corners> result(indices / 3);
  for (std::size_t i = 0; i < indices; ++i)
    std::tie(result[i / 3].exact[i % 3], result[i / 3].normals[i % 3]) = at(vertex(i));
  for (Corners& corners : result) corners = from_least(corners);
  std::sort(result.begin(), result.end());
  return result;
}

/// Every level has the triangles of the mesh's level, with their positions, normals and texture coordinates.
void expect_the_same_corners(const Mesh& mesh, const MeshLevels& levels) {
  const MeshStreams streams = make_streams(mesh, {.texture = true}, levels);
  const std::size_t bytes = index_bytes(mesh.positions.size());
  ASSERT_EQ(streams.ranges.size(), levels.levels.size() + 1);
  for (std::size_t level = 0; level < streams.ranges.size(); ++level) {
    const IndexRange& range = streams.ranges[level];
    const glm::uvec3* triangles =
        level == 0 ? mesh.triangles.data() : &levels.triangles[levels.levels[level - 1].first];
    ASSERT_EQ(range.count, 3 * (level == 0 ? mesh.triangles.size() : levels.levels[level - 1].count));
    const auto exact = [](const glm::vec3& p, const glm::vec2& uv) {
      return std::array{p.x, p.y, p.z, uv.x, uv.y};
    };
    const auto expected = sorted_corners(
        range.count, [&](std::size_t i) { return triangles[i / 3][static_cast<glm::length_t>(i % 3)]; },
        [&](std::uint32_t v) {
          return std::pair(exact(mesh.positions[v], mesh.uvs.empty() ? glm::vec2(0) : mesh.uvs[v]),
                           mesh.normals[v]);
        });
    const auto streamed = sorted_corners(
        range.count, [&](std::size_t i) { return index_at(streams, bytes, range.first + i); },
        [&](std::uint32_t v) {
          EXPECT_LT(v, range.vertices) << "a level reads only its first vertices";
          return std::pair(exact(streams.positions[v], streams.uvs[v]), unfolded(streams.normals[v]));
        });
    for (std::size_t i = 0; i < expected.size(); ++i) {
      ASSERT_EQ(streamed[i].exact, expected[i].exact);
      for (std::size_t corner = 0; corner < 3; ++corner)
        ASSERT_LT(glm::length(streamed[i].normals[corner] - expected[i].normals[corner]), 1e-4f);
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

TEST(MeshStreams, HaveClustersThatAreSmallAndHoldTheirTriangles) {
  Mesh flat = grid_mesh(200, 200, [](float u, float v) { return glm::vec3(u, 0, v); });
  std::mt19937 random(1);
  std::shuffle(flat.triangles.begin(), flat.triangles.end(), random);
  const MeshStreams streams = make_streams(flat, {}, {});
  const IndexRange& range = streams.ranges.at(0);
  ASSERT_EQ(range.clusters.size(), (flat.triangles.size() + kClusterTriangles - 1) / kClusterTriangles);
  double area = 0;
  for (const Bounds& box : range.clusters) area += (box.high.x - box.low.x) * (box.high.z - box.low.z);
  EXPECT_LT(area, 4) << "the mesh covers 1 x 1; in the given random order this is 300";
  for (std::uint32_t i = 0; i < range.count; ++i) {
    const glm::dvec3 p(streams.positions[index_at(streams, 2, range.first + i)]);
    const Bounds& box = range.clusters[i / 3 / kClusterTriangles];
    EXPECT_TRUE(glm::all(glm::lessThanEqual(box.low, p)) && glm::all(glm::lessThanEqual(p, box.high)));
  }
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
