/// LevelError: how far a coarser version of a mesh lies from the mesh, measured at points of both surfaces.
#pragma once

#include <memory>
#include <vector>

#include "stereo/lod/surface_distance.h"
#include "stereo/lod/weld.h"

namespace farshade {

/// Samples inside a triangle whose longest edge exceeds `spacing`: barycentric weights of a grid of points
/// about that far apart. None for smaller triangles.
[[nodiscard]] std::vector<glm::vec3> grid_points(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c,
                                                 float spacing);

struct MeasuredError {
  float distance = 0;     ///< as DetailLevel::error
  double normal_rad = 0;  ///< root mean square of the angles between normals
};

/// Measures the levels of one mesh, from fine to coarse.
class LevelError {
 public:
  /// Keeps the references. `positions` are those of the welded vertices.
  LevelError(const Mesh& mesh, const WeldedMesh& welded, std::span<const glm::vec3> positions);

  /// The error of a level with these triangles, which use a part of the vertices of the level before.
  /// `estimate`: about the expected distance.
  [[nodiscard]] MeasuredError measure(std::span<const glm::uvec3> level, float estimate);

 private:
  /// A point of the full mesh.
  struct Sample {
    glm::uvec3 corners;  ///< welded vertices
    glm::vec3 weights;   ///< barycentric
    float height = 0;    ///< of its triangle if that is large; 0 for a vertex
  };
  [[nodiscard]] glm::vec3 position(const Sample& sample) const;
  [[nodiscard]] float normal_error_rad(const Sample& sample, const NearestPoint& there,
                                       std::span<const glm::uvec3> level) const;
  [[nodiscard]] float attribute_distance(const Sample& sample, const NearestPoint& there,
                                         std::span<const glm::uvec3> level) const;
  void find_large();
  void find_gradients();

  const Mesh& mesh_;
  const WeldedMesh& welded_;
  std::span<const glm::vec3> positions_;
  SurfaceDistance full_;
  float spacing_ = 0;                          ///< of the points on large triangles
  std::vector<Sample> on_large_;               ///< points on the large triangles of the full mesh
  std::vector<bool> used_;                     ///< by the level before
  std::vector<std::uint32_t> removed_before_;  ///< vertices that the level before was the first to lack
  std::vector<float> errors_;                  ///< of the levels before
  struct Gradient {
    float uv = 0, color = 0;  ///< largest change per unit of length towards a neighbour
  };
  std::vector<Gradient> gradients_;
};

}  // namespace farshade
