#include "stereo/gltf/gltf_mesh.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <numeric>

#include "stereo/gltf/gltf_accessor.h"
#include "stereo/gltf/gltf_materials.h"

namespace farshade::gltf {
namespace {

std::vector<std::uint32_t> corners_of(const Document& document, const Primitive& primitive,
                                      std::size_t vertices) {
  if (const Index indices = index_of(primitive.indices)) return read_indices(document, *indices);
  std::vector<std::uint32_t> corners(vertices);
  std::iota(corners.begin(), corners.end(), 0u);
  return corners;
}

/// The normal of the triangle, as long as twice its area. Zero for a triangle that no ray can hit.
glm::dvec3 area_vector(const std::vector<glm::vec3>& positions, glm::uvec3 triangle) {
  const glm::dvec3 a(positions[triangle.x]), b(positions[triangle.y]), c(positions[triangle.z]);
  return glm::cross(b - a, c - a);
}

/// Triangles by glTF 2.0 section 3.7.2.1: every second triangle of a strip swaps two corners to keep the
/// winding. Leaves out triangles of vertices that are not there.
std::vector<glm::uvec3> triangles_of(const Document& document, const Primitive& primitive,
                                     std::size_t vertices) {
  const std::vector<std::uint32_t> corners = corners_of(document, primitive, vertices);
  const int mode = primitive.mode;
  const std::size_t count = mode == TINYGLTF_MODE_TRIANGLES ? corners.size() / 3 : corners.size() - 2;
  std::vector<glm::uvec3> triangles;
  triangles.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t odd = i % 2;
    const glm::uvec3 triangle = mode == TINYGLTF_MODE_TRIANGLES
                                    ? glm::uvec3(corners[3 * i], corners[3 * i + 1], corners[3 * i + 2])
                                : mode == TINYGLTF_MODE_TRIANGLE_STRIP
                                    ? glm::uvec3(corners[i], corners[i + 1 + odd], corners[i + 2 - odd])
                                    : glm::uvec3(corners[i + 1], corners[i + 2], corners[0]);
    if (std::max({triangle.x, triangle.y, triangle.z}) < vertices) triangles.push_back(triangle);
  }
  return triangles;
}

template <class T>
std::vector<T> by_corner(const std::vector<T>& stream, const std::vector<glm::uvec3>& triangles) {
  std::vector<T> result;
  if (stream.empty()) return result;
  result.reserve(3 * triangles.size());
  for (const glm::uvec3 t : triangles) result.insert(result.end(), {stream[t.x], stream[t.y], stream[t.z]});
  return result;
}

void by_corner(Deformable& deformable, const std::vector<glm::uvec3>& triangles) {
  deformable.positions = by_corner(deformable.positions, triangles);
  deformable.influences = by_corner(deformable.influences, triangles);
  for (Deformable::Target& target : deformable.targets) target = {by_corner(target.positions, triangles), {}};
}

/// Gives every triangle its own three vertices, with the normal of its plane.
void make_flat(farshade::Mesh& mesh) {
  mesh.normals.reserve(3 * mesh.triangles.size());
  for (const glm::uvec3 t : mesh.triangles) {
    const glm::dvec3 normal = area_vector(mesh.positions, t);
    const bool has_area = normal != glm::dvec3(0.0);
    mesh.normals.insert(mesh.normals.end(), 3,
                        has_area ? glm::vec3(glm::normalize(normal)) : glm::vec3(0, 1, 0));
  }
  if (mesh.deformable) by_corner(*mesh.deformable, mesh.triangles);
  mesh.positions = by_corner(mesh.positions, mesh.triangles);
  mesh.uvs = by_corner(mesh.uvs, mesh.triangles);
  mesh.colors = by_corner(mesh.colors, mesh.triangles);
  std::uint32_t corner = 0;
  for (glm::uvec3& t : mesh.triangles) {
    t = {corner, corner + 1, corner + 2};
    corner += 3;
  }
}

/// Normalises the normals. A normal of length zero is replaced by the mean of the adjacent triangles'
/// normals, weighted by area.
void make_unit(farshade::Mesh& mesh) {
  const auto has_direction = [](glm::vec3 n) {
    const double length = glm::length(glm::dvec3(n));
    return length > 1e-6 && length < 1e30;  // false for NaN
  };
  std::vector<glm::dvec3> around;
  if (!std::all_of(mesh.normals.begin(), mesh.normals.end(), has_direction)) {
    around.resize(mesh.normals.size());
    for (const glm::uvec3 t : mesh.triangles)
      for (const std::uint32_t vertex : {t.x, t.y, t.z}) around[vertex] += area_vector(mesh.positions, t);
  }
  for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
    glm::dvec3 normal(mesh.normals[i]);
    if (!has_direction(mesh.normals[i])) normal = around[i];
    const double length = glm::length(normal);
    mesh.normals[i] = length > 0.0 ? glm::vec3(normal / length) : glm::vec3(0, 1, 0);
  }
}

/// KHR_texture_transform: scale, then rotate counter-clockwise as seen on the image (v points down), then
/// translate. The text of the extension, three.js and the Khronos sample viewer agree on this.
std::vector<glm::vec2> texture_coordinates(const Document& document, const Primitive& primitive,
                                           const TextureUse& use, std::size_t vertices) {
  const Index accessor = attribute(primitive, use.semantic());
  if (!accessor) return std::vector<glm::vec2>(vertices, glm::vec2(0.0f));
  auto uvs = read_vectors<2>(document, *accessor);
  if (use.offset == glm::dvec2(0.0) && use.scale == glm::dvec2(1.0) && use.rotation_rad == 0.0) return uvs;
  constexpr double kLargest = std::numeric_limits<float>::max();  // a scale may be as large as a float
  const double cosine = std::cos(use.rotation_rad), sine = std::sin(use.rotation_rad);
  for (glm::vec2& uv : uvs) {
    const glm::dvec2 s = glm::dvec2(uv) * use.scale;
    const glm::dvec2 transformed =
        use.offset + glm::dvec2(cosine * s.x + sine * s.y, cosine * s.y - sine * s.x);
    uv = glm::vec2(glm::clamp(transformed, -kLargest, kLargest));
  }
  return uvs;
}

std::vector<glm::u8vec4> colors_from(const std::vector<glm::vec4>& colors) {
  std::vector<glm::u8vec4> result(colors.size());
  std::transform(colors.begin(), colors.end(), result.begin(),
                 [](glm::vec4 c) { return glm::u8vec4(glm::clamp(c, 0.0f, 1.0f) * 255.0f + 0.5f); });
  return result;
}

/// The weights of the node, else of its mesh; as many as there are targets.
std::vector<float> weights_of(const Document& document, const Node& node) {
  const Mesh& mesh = at(document.meshes, node.mesh);
  const std::vector<double>& given = node.weights.empty() ? mesh.weights : node.weights;
  std::vector<float> weights(targets_of(mesh), 0.0f);
  for (std::size_t i = 0; i < std::min(weights.size(), given.size()); ++i)
    weights[i] = static_cast<float>(glm::clamp(given[i], -kMostWeight, kMostWeight));
  return weights;
}

std::vector<Joint> joints_of(const Document& document, const Skin& skin, const std::vector<Index>& scene_node,
                             std::uint32_t still) {
  std::vector<glm::mat4> inverse_bind(skin.joints.size(), glm::mat4(1.0f));
  if (const Index accessor = index_of(skin.inverseBindMatrices))
    inverse_bind = read_matrices(document, *accessor);
  std::vector<Joint> joints;
  for (std::size_t i = 0; i < skin.joints.size(); ++i) {
    const Index node = at(scene_node, skin.joints[i]);
    joints.push_back(node ? Joint{*node, glm::dmat4(inverse_bind[i])} : Joint{still});
  }
  return joints;
}

/// Weights are divided by their sum, in which negative ones do not count.
std::vector<Deformable::Influence> influences_of(const Document& document, const Primitive& primitive) {
  const Index joints_at = attribute(primitive, "JOINTS_0"), weights_at = attribute(primitive, "WEIGHTS_0");
  if (!joints_at || !weights_at) return {};
  const std::vector<glm::vec4> joints = read_vectors<4>(document, *joints_at),
                               weights = read_vectors<4>(document, *weights_at);
  std::vector<Deformable::Influence> result(joints.size());
  for (std::size_t v = 0; v < result.size(); ++v) {
    const glm::vec4 w = glm::max(weights[v], glm::vec4(0.0f));
    const float sum = w.x + w.y + w.z + w.w;
    result[v] = {glm::u16vec4(joints[v]), sum > 0 ? w / sum : glm::vec4(1, 0, 0, 0)};
  }
  return result;
}

/// The vertices, normals and triangles.
farshade::Mesh begun_mesh(const Document& document, const Primitive& primitive) {
  farshade::Mesh mesh;
  mesh.positions = read_vectors<3>(document, attribute(primitive, "POSITION"));
  mesh.normals = read_vectors<3>(document, attribute(primitive, "NORMAL"));
  mesh.triangles = triangles_of(document, primitive, mesh.positions.size());
  return mesh;
}

/// Adds the rest to a begun mesh.
void complete(const Document& document, const Primitive& primitive, farshade::Mesh& mesh) {
  if (const auto texture = texture_of(document, primitive))
    mesh.uvs = texture_coordinates(document, primitive, *texture, mesh.positions.size());
  mesh.colors = colors_from(read_vectors<4>(document, attribute(primitive, "COLOR_0")));
  mesh.normals.empty() ? make_flat(mesh) : make_unit(mesh);
}

}  // namespace

void remove_without_area(farshade::Mesh& mesh) {
  std::erase_if(mesh.triangles, [&](const glm::uvec3& triangle) {
    return area_vector(mesh.positions, triangle) == glm::dvec3(0.0);
  });
}

farshade::Mesh mesh_from(const Document& document, const Primitive& primitive) {
  farshade::Mesh mesh = begun_mesh(document, primitive);
  remove_without_area(mesh);
  complete(document, primitive, mesh);
  return mesh;
}

farshade::Mesh deformable_mesh_from(const Document& document, const Primitive& primitive, bool skinned) {
  farshade::Mesh mesh = begun_mesh(document, primitive);
  mesh.deformable = {.positions = mesh.positions, .normals = mesh.normals};
  for (const auto& target : primitive.targets)
    mesh.deformable->targets.push_back({read_vectors<3>(document, attribute(target, "POSITION")),
                                        read_vectors<3>(document, attribute(target, "NORMAL"))});
  if (skinned) mesh.deformable->influences = influences_of(document, primitive);
  complete(document, primitive, mesh);
  if (!mesh.deformable->normals.empty()) mesh.deformable->normals = mesh.normals;
  return mesh;
}

bool deforms(const Document& document, std::uint32_t number, const WeightTracks& tracks) {
  const Node& node = document.nodes[number];
  if (node.skin >= 0) return true;
  const std::vector<float> weights = weights_of(document, node);
  const bool is_deformed = std::ranges::any_of(weights, [](float weight) { return weight != 0; });
  return is_deformed || (tracks.contains(static_cast<int>(number)) && !weights.empty());
}

Rig rig_of(const Document& document, std::uint32_t number, const std::vector<Index>& scene_node,
           std::uint32_t still, const WeightTracks& tracks) {
  const Node& node = document.nodes[number];
  Rig rig{.joints = {}, .weights = weights_of(document, node)};
  if (node.skin >= 0) rig.joints = joints_of(document, at(document.skins, node.skin), scene_node, still);
  const auto found = tracks.find(static_cast<int>(number));
  const std::size_t width = rig.weights.size();
  if (found == tracks.end() || width == 0) return rig;
  const WeightTrack& track = found->second;
  if (is_constant(track, width))
    std::ranges::copy(std::span(track.values).subspan(first_value(track, width), width), rig.weights.begin());
  else
    rig.track = track;
  return rig;
}

}  // namespace farshade::gltf
