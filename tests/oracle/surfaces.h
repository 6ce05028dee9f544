/// The oracle's triangles, in stage space and in double, and the two queries.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "tests/oracle/oracle.h"

namespace farshade::oracle {

struct Triangle {
  std::array<glm::dvec3, 3> position, normal;  ///< stage; normals of any length
  std::array<glm::dvec2, 3> uv{};
  std::array<double, 3> alpha{1, 1, 1};  ///< per vertex
  glm::dvec3 facing{0.0};                ///< towards the counter-clockwise side, any length
  const Material* material = nullptr;
  const Texture* texture = nullptr;
  std::uint32_t instance = 0;
  bool casts = true;
};

struct Ray {
  glm::dvec3 origin, direction;
};

struct Hit {
  const Triangle* triangle = nullptr;
  double t = 0, u = 0, v = 0;
};

class Surfaces {
 public:
  Surfaces(const Scene& scene, const SceneState& state, Search search);

  /// The nearest visible surface with t > 0.
  [[nodiscard]] std::optional<Hit> nearest(const Ray& ray) const;
  /// Whether any surface casts a shadow at 0 < t < end.
  [[nodiscard]] bool blocked(const Ray& ray, double end) const;

 private:
  struct Node {
    glm::dvec3 low, high;
    std::uint32_t first = 0, count = 0;  ///< a leaf's triangles
    std::uint32_t right = 0;             ///< right child of an inner node; the left child follows the node
  };
  std::uint32_t split(std::uint32_t first, std::uint32_t count, std::uint32_t leaf_size);
  template <class Visit>
  void visit(const Ray& ray, Visit&& visit) const;

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

}  // namespace farshade::oracle
