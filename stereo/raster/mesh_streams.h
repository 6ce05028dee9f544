/// Mesh streams: a mesh as the device stores it. Positions relative to a centre, octahedral normals, and the
/// triangles of all levels with indices of 16 bits where the mesh has few enough vertices. The triangles of a
/// level are sorted along a space-filling curve, so that successive ones form clusters that a frame can leave
/// out. Vertices are in the order in which the coarsest level reads them first, so that no level fetches more
/// memory than it needs. Pure; no device needed.
#pragma once

#include <cstddef>
#include <glm/gtc/type_precision.hpp>
#include <vector>

#include "stereo/lod/levels.h"
#include "stereo/plan/scene_plan.h"

namespace farshade {

/// One size or offset in bytes for each stream of a mesh.
struct StreamBytes {
  std::size_t positions = 0, normals = 0, uvs = 0, colors = 0, indices = 0;
  [[nodiscard]] std::size_t vertices() const { return positions + normals + uvs + colors; }
  [[nodiscard]] std::size_t total() const { return vertices() + indices; }
};

/// Successive triangles of a level that form a cluster. The last cluster of a level may have fewer.
inline constexpr std::uint32_t kClusterTriangles = 256;

/// The triangles of one level in the index stream of a mesh.
struct IndexRange {
  std::uint32_t first = 0, count = 0;  ///< indices
  std::uint32_t vertices = 0;          ///< the level reads only the first so many vertices
  std::vector<Bounds> clusters;        ///< bounding boxes, relative to the centre
};

struct MeshStreams {
  glm::dvec3 center{0.0};  ///< object space; positions are relative to it
  std::vector<glm::vec3> positions;
  std::vector<glm::i16vec2> normals;  ///< octahedral, 32767 = 1
  std::vector<glm::vec2> uvs;         ///< empty unless needed, as colors
  std::vector<glm::u8vec4> colors;
  std::vector<std::byte> indices;  ///< padded to a multiple of four bytes
  std::vector<IndexRange> ranges;  ///< of the mesh itself, then of its levels
};

/// The bytes of an index of a mesh with so many vertices.
[[nodiscard]] constexpr std::size_t index_bytes(std::size_t vertices) {
  return vertices <= std::size_t{1} << 16 ? 2 : 4;
}

/// The sizes of a mesh's streams. A stream that is not needed has size 0.
[[nodiscard]] StreamBytes stream_bytes(const Mesh& mesh, const SurfaceNeeds& needs, const MeshLevels& levels);

[[nodiscard]] MeshStreams make_streams(const Mesh& mesh, const SurfaceNeeds& needs, const MeshLevels& levels);

/// A unit normal as the device stores it: packSnorm2x16 of the octahedral map (gbuffer.frag).
[[nodiscard]] glm::i16vec2 octahedral(const glm::vec3& n);
/// The unit normal of a packed word.
[[nodiscard]] glm::vec3 from_octahedral(std::uint32_t packed);

/// The levels of one mesh of a scene; none if `levels` is empty.
[[nodiscard]] const MeshLevels& levels_of(const SceneLevels& levels, std::size_t mesh);

}  // namespace farshade
