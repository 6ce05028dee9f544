#include "stereo/draw/mesh_streams.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <glm/gtc/type_precision.hpp>

#include "stereo/base/check.h"

namespace farshade {
namespace {

static_assert(std::endian::native == std::endian::little);

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

/// As packSnorm2x16 of the octahedral map (gbuffer.frag).
glm::i16vec2 octahedral(const glm::vec3& n) {
  glm::vec2 p = glm::vec2(n) / (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
  if (n.z < 0)
    p = {(1 - std::abs(p.y)) * (p.x < 0 ? -1.0f : 1.0f), (1 - std::abs(p.x)) * (p.y < 0 ? -1.0f : 1.0f)};
  return {std::lround(p.x * 32767), std::lround(p.y * 32767)};
}

/// For each vertex of the mesh its place on the device. Vertices that no triangle uses come last.
std::vector<std::uint32_t> fetch_order(const Mesh& mesh, const MeshLevels& levels) {
  std::vector<glm::uvec3> coarsest_first;
  for (auto level = levels.levels.rbegin(); level != levels.levels.rend(); ++level)
    coarsest_first.insert(coarsest_first.end(), levels.triangles.begin() + level->first,
                          levels.triangles.begin() + level->first + level->count);
  coarsest_first.insert(coarsest_first.end(), mesh.triangles.begin(), mesh.triangles.end());
  std::vector<std::uint32_t> place(mesh.positions.size());
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

/// Writes the indices of some triangles and returns where they are.
IndexRange append(std::span<const glm::uvec3> triangles, const std::vector<std::uint32_t>& place,
                  std::uint32_t first, std::vector<std::byte>& bytes) {
  IndexRange range{first, narrow<std::uint32_t>(triangles.size() * 3), 0};
  const std::size_t size = index_bytes(place.size());
  std::byte* to = bytes.data() + std::size_t{first} * size;
  for (const glm::uvec3& t : triangles)
    for (const std::uint32_t vertex : {t.x, t.y, t.z}) {
      std::memcpy(to, &place[vertex], size);  // little-endian: the low bytes come first
      to += size;
      range.vertices = std::max(range.vertices, place[vertex] + 1);
    }
  return range;
}

}  // namespace

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
  const std::vector<std::uint32_t> place = fetch_order(mesh, levels);
  MeshStreams streams;
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
  streams.ranges.push_back(append(mesh.triangles, place, 0, streams.indices));
  for (const DetailLevel& level : levels.levels) {
    const IndexRange& before = streams.ranges.back();
    streams.ranges.push_back(append(std::span(levels.triangles).subspan(level.first, level.count), place,
                                    before.first + before.count, streams.indices));
  }
  return streams;
}

const MeshLevels& levels_of(const SceneLevels& levels, std::size_t mesh) {
  static const MeshLevels none;
  return levels.empty() ? none : levels[mesh];
}

}  // namespace farshade
