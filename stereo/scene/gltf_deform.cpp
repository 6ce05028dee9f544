#include "stereo/scene/gltf_deform.h"

#include <cmath>
#include <glm/matrix.hpp>

#include "stereo/scene/gltf_accessor.h"

namespace farshade::gltf {
namespace {

/// The normal matrix of a blended transform. A transform that flattens space keeps the normal's direction.
glm::dvec3 turned(const glm::dmat3& m, const glm::dvec3& normal) {
  const glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
  const glm::dvec3 result = cofactors * normal * (glm::determinant(m) < 0 ? -1.0 : 1.0);
  return glm::length(result) > 0 ? glm::normalize(result) : normal;
}

void morph(const Document& document, const Primitive& primitive, std::span<const double> weights,
           Vertices& vertices) {
  for (std::size_t i = 0; i < std::min(weights.size(), primitive.targets.size()); ++i) {
    const MorphTarget& target = primitive.targets[i];
    const auto add = [&](Index accessor, std::vector<glm::vec3>& to) {
      if (weights[i] == 0 || !accessor || to.empty()) return;
      const std::vector<glm::vec3> by = read_vectors<3>(document, *accessor);
      for (std::size_t v = 0; v < to.size(); ++v) to[v] += static_cast<float>(weights[i]) * by[v];
    };
    add(target.position, vertices.positions);
    add(target.normal, vertices.normals);
  }
}

/// Linear blend skinning, glTF 2.0 section 3.7.3.3. Weights are divided by their sum.
void skin(const Document& document, const Primitive& primitive, std::span<const Affine<Stage, Object>> joints,
          Vertices& vertices) {
  const Index joints_at = primitive.attribute("JOINTS_0"), weights_at = primitive.attribute("WEIGHTS_0");
  if (!joints_at || !weights_at) return;
  const std::vector<glm::vec4> numbers = read_vectors<4>(document, *joints_at),
                               weights = read_vectors<4>(document, *weights_at);
  vertices.mirrored.resize(vertices.positions.size());
  for (std::size_t v = 0; v < vertices.positions.size(); ++v) {
    const double sum = double{weights[v].x} + weights[v].y + weights[v].z + weights[v].w;
    glm::dmat4 blended(0.0);
    for (int i = 0; i < 4; ++i) {
      const double weight = sum > 0 ? weights[v][i] / sum : i == 0;
      if (weight != 0) blended += weight * joints[static_cast<std::size_t>(numbers[v][i])].matrix;
    }
    vertices.mirrored[v] = glm::determinant(glm::dmat3(blended)) < 0;
    vertices.positions[v] = glm::vec3(blended * glm::dvec4(glm::dvec3(vertices.positions[v]), 1.0));
    if (!vertices.normals.empty())
      vertices.normals[v] = glm::vec3(turned(glm::dmat3(blended), glm::dvec3(vertices.normals[v])));
  }
}

}  // namespace

std::vector<Affine<Stage, Object>> joints_of(const Document& document, const Skin& skin, const Poses& poses) {
  std::vector<glm::mat4> inverse_bind(skin.joints.size(), glm::mat4(1.0f));
  if (skin.inverse_bind) inverse_bind = read_matrices(document, *skin.inverse_bind);
  std::vector<Affine<Stage, Object>> joints;
  for (std::size_t i = 0; i < skin.joints.size(); ++i) {
    const auto& pose = poses[skin.joints[i]];
    joints.push_back({pose ? pose->matrix * glm::dmat4(inverse_bind[i]) : glm::dmat4(1.0)});
  }
  return joints;
}

std::span<const double> weights_of(const Document& document, const Node& node) {
  const Mesh& mesh = document.meshes[*node.mesh];
  const std::vector<double>& weights = node.weights.empty() ? mesh.weights : node.weights;
  const bool has_targets = std::ranges::any_of(
      mesh.primitives, [](const Primitive& primitive) { return !primitive.targets.empty(); });
  const bool moves = std::ranges::any_of(weights, [](double weight) { return weight != 0; });
  return has_targets && moves ? std::span<const double>(weights) : std::span<const double>();
}

Vertices vertices_of(const Document& document, const Primitive& primitive, const Deformation& deformation) {
  Vertices vertices{read_vectors<3>(document, *primitive.attribute("POSITION")), {}, {}};
  if (const Index normal = primitive.attribute("NORMAL"))
    vertices.normals = read_vectors<3>(document, *normal);
  morph(document, primitive, deformation.weights, vertices);
  if (!deformation.joints.empty()) skin(document, primitive, deformation.joints, vertices);
  return vertices;
}

}  // namespace farshade::gltf
