#include "stereo/raster/mesh_streams.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <glm/gtc/type_precision.hpp>
#include <glm/packing.hpp>
#include <limits>
#include <numeric>

#include "stereo/base/check.h"

namespace farshade {
namespace {

static_assert(std::endian::native == std::endian::little);

/// The bounding box of no point.
constexpr Bounds kNoPoint{glm::dvec3(std::numeric_limits<double>::max()),
                          glm::dvec3(std::numeric_limits<double>::lowest())};

/// The point that a mesh's vertices are sent relative to. A mesh far from its own origin, as in map
/// coordinates, would lose digits where the device adds up float products. All other meshes keep their
/// origin. (The relative-to-centre method: P. Cozzi, K. Ring, "3D Engine Design for Virtual Globes", 2011,
/// chapter 5.)
glm::dvec3 center_of(const std::vector<glm::vec3>& positions) {
  constexpr double kFar = 16;  // distance from the origin in half sizes of the mesh
  const auto [low, high] = bounds_of(positions);
  const glm::dvec3 center = (low + high) * 0.5;
  return glm::length(center) > kFar * 0.5 * glm::length(high - low) ? center : glm::dvec3(0.0);
}

/// Sorts the triangles of a cluster so that successive ones share vertices. `number` has an entry for each
/// vertex of the mesh, of any value.
void share_vertices(std::span<glm::uvec3> cluster, std::vector<std::uint32_t>& number) {
  std::vector<std::uint32_t> vertices;  // of the cluster, in the order of their numbers
  std::vector<glm::uvec3> numbered(cluster.begin(), cluster.end());
  for (glm::uvec3& t : numbered)
    for (glm::length_t corner = 0; corner < 3; ++corner) {
      std::uint32_t& own = number[t[corner]];
      if (own >= vertices.size() || vertices[own] != t[corner]) {
        own = narrow<std::uint32_t>(vertices.size());
        vertices.push_back(t[corner]);
      }
      t[corner] = own;
    }
  meshopt_optimizeVertexCacheFifo(&numbered[0].x, &numbered[0].x, numbered.size() * 3, vertices.size(), 16);
  for (std::size_t i = 0; i < cluster.size(); ++i)
    cluster[i] = {vertices[numbered[i].x], vertices[numbered[i].y], vertices[numbered[i].z]};
}

/// The triangles in clusters that lie close together.
std::vector<glm::uvec3> clustered(std::span<const glm::uvec3> triangles,
                                  const std::vector<glm::vec3>& positions) {
  std::vector<glm::uvec3> result(triangles.begin(), triangles.end());
  if (triangles.size() <= kClusterTriangles) return result;
  meshopt_spatialSortTriangles(&result[0].x, &triangles[0].x, triangles.size() * 3, &positions[0].x,
                               positions.size(), sizeof(glm::vec3));
  std::vector<std::uint32_t> number(positions.size(), 0);
  for (std::span<glm::uvec3> rest(result); !rest.empty();) {
    const std::span<glm::uvec3> cluster = rest.first(std::min<std::size_t>(kClusterTriangles, rest.size()));
    share_vertices(cluster, number);
    rest = rest.subspan(cluster.size());
  }
  return result;
}

/// The triangles of the mesh itself, then of its levels.
std::vector<std::vector<glm::uvec3>> clustered_ranges(const Mesh& mesh, const MeshLevels& levels) {
  std::vector<std::vector<glm::uvec3>> ranges{clustered(mesh.triangles, mesh.positions)};
  for (const DetailLevel& level : levels.levels)
    ranges.push_back(
        clustered(std::span(levels.triangles).subspan(level.first, level.count), mesh.positions));
  return ranges;
}

/// For each of the vertices its place on the device. Vertices that no triangle uses come last.
std::vector<std::uint32_t> fetch_order(const std::vector<std::vector<glm::uvec3>>& ranges,
                                       std::size_t vertices) {
  std::vector<glm::uvec3> coarsest_first;
  for (auto range = ranges.rbegin(); range != ranges.rend(); ++range)
    coarsest_first.insert(coarsest_first.end(), range->begin(), range->end());
  std::vector<std::uint32_t> place(vertices);
  std::size_t used = 0;
  if (!coarsest_first.empty())
    used = meshopt_optimizeVertexFetchRemap(place.data(), &coarsest_first[0].x, coarsest_first.size() * 3,
                                            place.size());
  else
    std::ranges::fill(place, ~0u);
  for (std::uint32_t& at : place)
    if (at == ~0u) at = narrow<std::uint32_t>(used++);
  return place;
}

/// The values of a stream in their places; neutral values if the mesh lacks the stream.
template <class T>
std::vector<T> placed(const std::vector<T>& values, const std::vector<std::uint32_t>& place, T neutral) {
  std::vector<T> result(place.size(), neutral);
  for (std::size_t i = 0; i < values.size(); ++i) result[place[i]] = values[i];
  return result;
}

/// Writes the indices of some triangles, from index number `first` on, and returns where they are.
/// `positions` are in their places.
IndexRange append(std::span<const glm::uvec3> triangles, const std::vector<std::uint32_t>& place,
                  const std::vector<glm::vec3>& positions, std::uint32_t first,
                  std::vector<std::byte>& bytes) {
  IndexRange range{first, narrow<std::uint32_t>(triangles.size() * 3), 0, {}};
  const std::size_t size = index_bytes(place.size());
  std::byte* to = bytes.data() + std::size_t{first} * size;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const glm::uvec3& t = triangles[i];
    if (i % kClusterTriangles == 0) range.clusters.push_back(kNoPoint);
    for (const std::uint32_t vertex : {t.x, t.y, t.z}) {
      std::memcpy(to, &place[vertex], size);  // little-endian: the low bytes come first
      to += size;
      range.vertices = std::max(range.vertices, place[vertex] + 1);
      Bounds& cluster = range.clusters.back();
      cluster.low = glm::min(cluster.low, glm::dvec3(positions[place[vertex]]));
      cluster.high = glm::max(cluster.high, glm::dvec3(positions[place[vertex]]));
    }
  }
  return range;
}

}  // namespace

glm::i16vec2 octahedral(const glm::vec3& n) {
  glm::vec2 p = glm::vec2(n) / (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
  if (n.z < 0)
    p = {(1 - std::abs(p.y)) * (p.x < 0 ? -1.0f : 1.0f), (1 - std::abs(p.x)) * (p.y < 0 ? -1.0f : 1.0f)};
  return {std::lround(p.x * 32767), std::lround(p.y * 32767)};
}

glm::vec3 from_octahedral(std::uint32_t packed) {
  const glm::vec2 p = glm::unpackSnorm2x16(packed);
  glm::vec3 n(p, 1 - std::abs(p.x) - std::abs(p.y));
  if (n.z < 0) {
    n.x = (1 - std::abs(p.y)) * (p.x < 0 ? -1.0f : 1.0f);
    n.y = (1 - std::abs(p.x)) * (p.y < 0 ? -1.0f : 1.0f);
  }
  return glm::normalize(n);
}

StreamBytes stream_bytes(const Mesh& mesh, const SurfaceNeeds& needs, const MeshLevels& levels) {
  const std::size_t count = mesh.positions.size(),
                    indices = (mesh.triangles.size() + levels.triangles.size()) * 3 * index_bytes(count);
  return {.positions = count * sizeof(glm::vec3),
          .normals = count * sizeof(glm::i16vec2),
          .uvs = needs.texture ? count * sizeof(glm::vec2) : 0,
          .colors = needs.vertex_color ? count * sizeof(glm::u8vec4) : 0,
          .indices = (indices + 3) / 4 * 4};
}

MeshStreams make_streams(const Mesh& mesh, const SurfaceNeeds& needs, const MeshLevels& levels) {
  const std::vector<std::vector<glm::uvec3>> ranges = clustered_ranges(mesh, levels);
  std::vector<std::uint32_t> place = fetch_order(ranges, mesh.positions.size());
  MeshStreams streams;
  if (mesh.deformable)
    std::iota(place.begin(), place.end(), 0u);  // DeformedVertices writes them in the mesh's order
  else
    streams.center = center_of(mesh.positions);
  streams.positions.resize(place.size());
  streams.normals.resize(place.size());
  for (std::size_t i = 0; i < place.size(); ++i) {
    streams.positions[place[i]] = glm::vec3(glm::dvec3(mesh.positions[i]) - streams.center);
    streams.normals[place[i]] = octahedral(mesh.normals[i]);
  }
  if (needs.texture) streams.uvs = placed(mesh.uvs, place, glm::vec2(0));
  if (needs.vertex_color) streams.colors = placed(mesh.colors, place, glm::u8vec4(255));
  streams.indices.resize(stream_bytes(mesh, needs, levels).indices);
  std::uint32_t first = 0;
  for (const std::vector<glm::uvec3>& triangles : ranges) {
    streams.ranges.push_back(append(triangles, place, streams.positions, first, streams.indices));
    first += streams.ranges.back().count;
  }
  return streams;
}

const MeshLevels& levels_of(const SceneLevels& levels, std::size_t mesh) {
  static const MeshLevels none;
  return levels.empty() ? none : levels[mesh];
}

}  // namespace farshade
