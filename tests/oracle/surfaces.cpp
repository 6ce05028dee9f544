#include "tests/oracle/surfaces.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>

namespace farshade::oracle {
namespace {

constexpr double kEndless = std::numeric_limits<double>::infinity();

/// Moeller and Trumbore, both sides. A triangle includes its edges and a margin slightly larger than
/// rounding, so that a ray through a shared edge does not pass between two triangles.
std::optional<Hit> meet(const Triangle& triangle, const Ray& ray) {
  const auto& [a, b, c] = triangle.position;
  const glm::dvec3 ab = b - a, ac = c - a, across = glm::cross(ray.direction, ac);
  const double det = glm::dot(ab, across);
  if (det == 0) return std::nullopt;
  const glm::dvec3 from_a = ray.origin - a, up = glm::cross(from_a, ab);
  const Hit hit{&triangle, glm::dot(ac, up) / det, glm::dot(from_a, across) / det,
                glm::dot(ray.direction, up) / det};
  constexpr double kEdge = 1e-13;
  const bool inside = hit.u >= -kEdge && hit.v >= -kEdge && hit.u + hit.v <= 1 + kEdge;
  return inside && hit.t > 0 ? std::optional(hit) : std::nullopt;
}

template <class Value>
Value mix(const std::array<Value, 3>& of, const Hit& hit) {
  return of[0] * (1 - hit.u - hit.v) + of[1] * hit.u + of[2] * hit.v;
}

/// The texel that a wrapped index refers to.
std::uint32_t wrapped(double index, Wrap wrap, double size) {
  if (wrap == Wrap::ClampToEdge) return static_cast<std::uint32_t>(std::clamp(index, 0.0, size - 1));
  const double period = wrap == Wrap::Repeat ? size : 2 * size;
  const double inside = index - period * std::floor(index / period);
  return static_cast<std::uint32_t>(inside < size ? inside : 2 * size - 1 - inside);
}

double texture_alpha(const Texture& texture, const glm::dvec2& uv) {
  const double width = texture.image.size.width, height = texture.image.size.height;
  const double x = uv.x * width - 0.5, y = uv.y * height - 0.5, x0 = std::floor(x), y0 = std::floor(y);
  double sum = 0;
  for (const double dy : {0.0, 1.0})
    for (const double dx : {0.0, 1.0}) {
      const double weight = (1 - std::abs(x - x0 - dx)) * (1 - std::abs(y - y0 - dy));
      const auto column = wrapped(x0 + dx, texture.wrap_u, width),
                 row = wrapped(y0 + dy, texture.wrap_v, height);
      sum += weight * texture.image.at(column, row).a / 255.0;
    }
  return sum;
}

bool is_hole(const Hit& hit) {
  const Triangle& triangle = *hit.triangle;
  if (!triangle.material->alpha_cutoff) return false;
  double alpha = double{triangle.material->base_color.a} * mix(triangle.alpha, hit);
  if (triangle.texture != nullptr) alpha *= texture_alpha(*triangle.texture, mix(triangle.uv, hit));
  return alpha < double{*triangle.material->alpha_cutoff};
}

bool is_seen(const Hit& hit, const Ray& ray) {
  const Triangle& triangle = *hit.triangle;
  return (triangle.material->double_sided || glm::dot(ray.direction, triangle.facing) < 0) && !is_hole(hit);
}

/// A mesh as `place` takes it. `stage_from_object` of a vertex, and its position before that.
struct Vertices {
  std::vector<glm::dmat4> stage_from_object;  ///< one for all vertices, or one each
  std::vector<glm::dvec3> positions, normals;
  [[nodiscard]] const glm::dmat4& transform(std::uint32_t vertex) const {
    return stage_from_object[stage_from_object.size() == 1 ? 0 : vertex];
  }
};

Vertices vertices_of(const Mesh& mesh, const glm::dmat4& stage_from_object) {
  return {{stage_from_object},
          {mesh.positions.begin(), mesh.positions.end()},
          {mesh.normals.begin(), mesh.normals.end()}};
}

/// Blends the transforms of joints in double and in the stage.
void skin(const Scene& scene, const Rig& rig, const Deformable& from, Time time, Vertices& vertices) {
  const auto stage_from_node = stage_from_nodes(scene, time);
  vertices.stage_from_object.clear();
  for (const Deformable::Influence& influence : from.influences) {
    glm::dmat4 blended(0.0);
    for (int i = 0; i < 4; ++i) {
      const Joint& joint = rig.joints[influence.joints[i]];
      blended += stage_from_node[joint.node].matrix * joint.joint_from_bind * double{influence.weights[i]};
    }
    vertices.stage_from_object.push_back(blended);
  }
}

Vertices deformed_vertices(const Scene& scene, const Instance& instance, const SceneState& state,
                           const glm::dmat4& stage_from_object) {
  const Mesh& mesh = scene.meshes[instance.mesh];
  if (!instance.rig) return vertices_of(mesh, stage_from_object);
  const Deformable& from = *mesh.deformable;
  Vertices vertices = vertices_of(mesh, stage_from_object);
  vertices.positions.assign(from.positions.begin(), from.positions.end());
  if (!from.normals.empty()) vertices.normals.assign(from.normals.begin(), from.normals.end());
  for (std::size_t target = 0; target < from.targets.size(); ++target) {
    const double weight = state.rigs[*instance.rig].weights[target];
    for (std::size_t v = 0; v < vertices.positions.size(); ++v) {
      vertices.positions[v] += weight * glm::dvec3(from.targets[target].positions[v]);
      if (!from.normals.empty()) vertices.normals[v] += weight * glm::dvec3(from.targets[target].normals[v]);
    }
  }
  const Rig& rig = scene.rigs[*instance.rig];
  if (!rig.joints.empty()) skin(scene, rig, from, state.scene_time, vertices);
  return vertices;
}

Triangle place(const Scene& scene, const Mesh& mesh, const glm::uvec3& vertices, const Vertices& at) {
  const Material& material = scene.materials[mesh.material];
  Triangle result{};
  result.material = &material;
  if (material.texture && !mesh.uvs.empty()) result.texture = &scene.textures[*material.texture];
  for (int i = 0; i < 3; ++i) {
    const auto corner = static_cast<std::size_t>(i);
    const std::uint32_t vertex = vertices[i];
    const glm::dmat4& stage_from_object = at.transform(vertex);
    const glm::dmat3 normal_from_object = glm::inverse(glm::transpose(glm::dmat3(stage_from_object)));
    result.position[corner] = glm::dvec3(stage_from_object * glm::dvec4(at.positions[vertex], 1.0));
    result.normal[corner] = glm::normalize(normal_from_object * at.normals[vertex]);
    if (!mesh.uvs.empty()) result.uv[corner] = mesh.uvs[vertex];
    if (!mesh.colors.empty()) result.alpha[corner] = mesh.colors[vertex].a / 255.0;
  }
  const auto& [a, b, c] = result.position;
  // A skin has turned mirrored triangles over already.
  const bool is_skinned = mesh.deformable && !mesh.deformable->influences.empty();
  const bool mirrored = !is_skinned && glm::determinant(glm::dmat3(at.transform(vertices.x))) < 0;
  result.facing = glm::cross(b - a, c - a) * (mirrored ? -1.0 : 1.0);
  if (mesh.deformable && mesh.deformable->normals.empty()) result.normal.fill(glm::normalize(result.facing));
  return result;
}

bool passes(const glm::dvec3& low, const glm::dvec3& high, const Ray& ray) {
  double from = 0, to = kEndless;
  for (int axis = 0; axis < 3; ++axis) {
    const double o = ray.origin[axis], d = ray.direction[axis];
    if (d == 0) {
      if (o < low[axis] || o > high[axis]) return false;
      continue;
    }
    const double a = (low[axis] - o) / d, b = (high[axis] - o) / d;
    from = std::max(from, std::min(a, b) * (1 - 1e-12));
    to = std::min(to, std::max(a, b) * (1 + 1e-12));
  }
  return from <= to;
}

}  // namespace

Surfaces::Surfaces(const Scene& scene, const SceneState& state, Search search) {
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
    const glm::dmat4& stage_from_object = state.stage_from_object[i].matrix;
    if (glm::determinant(glm::dmat3(stage_from_object)) == 0) continue;
    const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
    const Vertices at = deformed_vertices(scene, scene.instances[i], state, stage_from_object);
    for (const glm::uvec3& vertices : mesh.triangles) {
      triangles_.push_back(place(scene, mesh, vertices, at));
      triangles_.back().instance = i;
      triangles_.back().casts = scene.instances[i].casts;
    }
  }
  const auto count = static_cast<std::uint32_t>(triangles_.size());
  if (count > 0) split(0, count, search == Search::Tree ? 4 : count);
}

std::uint32_t Surfaces::split(std::uint32_t first, std::uint32_t count, std::uint32_t leaf_size) {
  const auto number = static_cast<std::uint32_t>(nodes_.size());
  Node node{glm::dvec3(kEndless), glm::dvec3(-kEndless), first, count, 0};
  for (std::uint32_t i = first; i < first + count; ++i)
    for (const glm::dvec3& p : triangles_[i].position) {
      node.low = glm::min(node.low, p);
      node.high = glm::max(node.high, p);
    }
  nodes_.push_back(node);
  if (count <= leaf_size) return number;

  const glm::dvec3 extent = node.high - node.low;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const auto middle_of = [axis](const Triangle& t) {
    return t.position[0][axis] + t.position[1][axis] + t.position[2][axis];
  };
  const std::uint32_t half = count / 2;
  const auto start = triangles_.begin() + first;
  std::nth_element(start, start + half, start + count,
                   [&](const Triangle& a, const Triangle& b) { return middle_of(a) < middle_of(b); });
  split(first, half, leaf_size);
  const std::uint32_t right = split(first + half, count - half, leaf_size);
  nodes_[number].right = right;
  nodes_[number].count = 0;
  return number;
}

/// `visit` is called for every triangle that the ray may meet and returns true to stop.
template <class Visit>
void Surfaces::visit(const Ray& ray, Visit&& visit) const {
  std::array<std::uint32_t, 64> waiting;
  std::size_t count = 0;
  if (!nodes_.empty()) waiting[count++] = 0;
  while (count > 0) {
    const std::uint32_t number = waiting[--count];
    const Node& node = nodes_[number];
    if (!passes(node.low, node.high, ray)) continue;
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
      if (visit(triangles_[i])) return;
    if (node.count > 0) continue;
    waiting[count++] = node.right;
    waiting[count++] = number + 1;
  }
}

std::optional<Hit> Surfaces::nearest(const Ray& ray) const {
  std::optional<Hit> best;
  visit(ray, [&](const Triangle& triangle) {
    const std::optional<Hit> hit = meet(triangle, ray);
    if (hit && (!best || hit->t < best->t) && is_seen(*hit, ray)) best = hit;
    return false;
  });
  return best;
}

bool Surfaces::blocked(const Ray& ray, double end) const {
  bool found = false;
  visit(ray, [&](const Triangle& triangle) {
    const std::optional<Hit> hit = triangle.casts ? meet(triangle, ray) : std::nullopt;
    found = hit && hit->t < end && !is_hole(*hit);
    return found;
  });
  return found;
}

}  // namespace farshade::oracle
