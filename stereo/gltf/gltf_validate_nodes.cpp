/// Validation of the nodes (a forest), their transforms, and the scenes.
#include <cmath>

#include "stereo/gltf/gltf_accessor.h"
#include "stereo/gltf/gltf_validate.h"

namespace farshade::gltf {
namespace {

/// Below this ratio of the determinant to the product of the column lengths, a matrix counts as singular.
constexpr double kLeastRelativeVolume = 1e-10;
/// Largest length, metres, to which the transforms of the nodes may scale one unit of a node's space.
constexpr double kMaxReach = 1e12;

std::string node_label(const Document& document, std::size_t index) {
  return label("node", index, document.nodes[index].name);
}

Checked check_matrix(const std::string& name, const glm::dmat4& m) {
  if (glm::dvec4(m[0][3], m[1][3], m[2][3], m[3][3]) != glm::dvec4(0, 0, 0, 1))
    return malformed(name + ": the last row of its matrix is not 0 0 0 1");
  const glm::dvec3 x(m[0]), y(m[1]), z(m[2]);
  const double lengths = glm::length(x) * glm::length(y) * glm::length(z);
  const double volume = std::abs(glm::dot(x, glm::cross(y, z)));
  if (!(lengths > 0.0) || !(volume > kLeastRelativeVolume * lengths))
    return malformed(name + ": its matrix cannot be inverted");
  return {};
}

Checked check_transform(const Document& document, std::size_t index, const Node& node, bool scale_moves) {
  const std::string name = node_label(document, index);
  if (const auto matrix = matrix_of(node)) return check_matrix(name, *matrix);
  if (std::abs(glm::length(rotation_of(node)) - 1.0) > 0.01)
    return malformed(name + ": its rotation is not a unit quaternion");
  const glm::dvec3 scale = scale_of(node);
  if ((scale.x == 0 || scale.y == 0 || scale.z == 0) && !scale_moves)
    return malformed(name + ": its scale is 0 and cannot be inverted");
  return {};
}

Checked check_references(const Document& document, std::size_t index, const Node& node) {
  const std::string name = node_label(document, index);
  if (!points_into(document.meshes, node.mesh))
    return malformed(name + ": there is no " + label("mesh", node.mesh));
  if (const Index light = light_of(node); light && *light >= document.lights.size())
    return malformed(name + ": there is no " + label("light", *light));
  if (!points_into(document.cameras, node.camera))
    return malformed(name + ": there is no " + label("camera", node.camera));
  if (!points_into(document.skins, node.skin))
    return malformed(name + ": there is no " + label("skin", node.skin));
  return {};
}

/// Checks that every child exists and has one parent. Fills `parents`.
Checked check_children(const Document& document, std::vector<Index>& parents) {
  return check_each(document.nodes, [&](std::size_t i, const Node& node) -> Checked {
    for (const int child : node.children) {
      if (!points_into(document.nodes, child))
        return malformed(node_label(document, i) + ": there is no child " + label("node", child));
      Index& parent = at(parents, child);
      if (parent)
        return malformed(label("node", child, at(document.nodes, child).name) + " has two parents, " +
                         label("node", *parent) + " and " + label("node", i));
      parent = static_cast<std::uint32_t>(i);
    }
    return {};
  });
}

/// Every node has at most one parent here, so a node that no root reaches is part of a cycle or below one.
Checked check_forest(const Document& document, const std::vector<Index>& parents, std::uint32_t most_depth) {
  std::vector<int> roots;
  for (std::size_t i = 0; i < parents.size(); ++i)
    if (!parents[i]) roots.push_back(static_cast<int>(i));
  std::vector<std::uint32_t> depth(parents.size(), 0);
  for (const std::uint32_t i : parents_first(document, roots)) {
    depth[i] = parents[i] ? depth[*parents[i]] + 1 : 1;
    if (depth[i] > most_depth)
      return fail(Fault::OutOfRange, node_label(document, i) + " is nested deeper than " +
                                         std::to_string(most_depth) + " levels");
  }
  const auto lost = std::find(depth.begin(), depth.end(), 0u);
  if (lost == depth.end()) return {};
  return malformed(node_label(document, static_cast<std::size_t>(lost - depth.begin())) +
                   " is its own ancestor or hangs below such a node");
}

Checked check_scenes(const Document& document, const std::vector<Index>& parents) {
  if (!points_into(document.scenes, document.defaultScene))
    return malformed("the default " + label("scene", document.defaultScene) + " is not there");
  return check_each(document.scenes, [&](std::size_t s, const tinygltf::Scene& scene) -> Checked {
    std::set<int> seen;
    for (const int root : scene.nodes) {
      if (!points_into(document.nodes, root))
        return malformed(label("scene", s) + ": there is no " + label("node", root));
      const std::string name = label("node", root, at(document.nodes, root).name);
      if (at(parents, root)) return malformed(label("scene", s) + ": " + name + " is no root");
      if (!seen.insert(root).second) return malformed(label("scene", s) + ": " + name + " is named twice");
    }
    return {};
  });
}

/// Upper bounds for a node: the factor by which it scales lengths, and the distance of its origin.
struct Stretch {
  double scale = 1, offset = 0;
};

Stretch rest_stretch(const Node& node) {
  if (const auto matrix = matrix_of(node)) {
    const glm::dmat4& m = *matrix;
    const double squares = glm::dot(m[0], m[0]) + glm::dot(m[1], m[1]) + glm::dot(m[2], m[2]);
    return {std::sqrt(squares), glm::length(glm::dvec3(m[3]))};
  }
  return {glm::length(scale_of(node)), glm::length(translation_of(node))};
}

/// Upper bound of a cubic spline: its largest value plus its largest tangent times the time between keys.
double largest_output(const Document& document, const AnimationSampler& sampler) {
  double largest = 0;
  for (const glm::vec3 v : read_vectors<3>(document, static_cast<std::uint32_t>(sampler.output)))
    largest = std::max(largest, glm::length(glm::dvec3(v)));
  const bool has_tangents = sampler.interpolation == "CUBICSPLINE";
  if (!has_tangents) return largest;
  return largest * (1.0 + read_scalars(document, static_cast<std::uint32_t>(sampler.input)).back());
}

}  // namespace

std::set<int> nodes_with_moving(const Document& document, std::string_view path) {
  std::set<int> nodes;
  for (const Animation& animation : document.animations)
    for (const AnimationChannel& channel : animation.channels)
      if (channel.target_path == path) nodes.insert(channel.target_node);
  return nodes;
}

std::vector<std::uint32_t> parents_first(const Document& document, const std::vector<int>& roots) {
  std::vector<std::uint32_t> order(roots.begin(), roots.end());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto& children = document.nodes[order[i]].children;
    order.insert(order.end(), children.begin(), children.end());
  }
  return order;
}

Checked validate_nodes(const Document& document, const SceneLimits& limits) {
  std::vector<Index> parents(document.nodes.size());
  const std::set<int> moving = nodes_with_moving(document, "scale");
  return check_each(document.nodes,
                    [&](auto i, const auto& node) { return check_references(document, i, node); })
      .and_then([&] {
        return check_each(document.nodes, [&](auto i, const auto& node) {
          return check_transform(document, i, node, moving.contains(static_cast<int>(i)));
        });
      })
      .and_then([&] { return check_children(document, parents); })
      .and_then([&] { return check_forest(document, parents, limits.node_depth); })
      .and_then([&] { return check_scenes(document, parents); });
}

Checked validate_reach(const Document& document) {
  std::vector<Stretch> stretch(document.nodes.size());
  for (std::size_t i = 0; i < stretch.size(); ++i) stretch[i] = rest_stretch(document.nodes[i]);
  for (const Animation& animation : document.animations)
    for (const AnimationChannel& channel : animation.channels) {
      if (channel.target_path != "translation" && channel.target_path != "scale") continue;
      const double largest = largest_output(document, at(animation.samplers, channel.sampler));
      Stretch& of = at(stretch, channel.target_node);
      double& bound = channel.target_path == "scale" ? of.scale : of.offset;
      bound = std::max(bound, largest);
    }
  std::vector<bool> is_root(document.nodes.size(), true);
  for (const Node& node : document.nodes)
    for (const int child : node.children) is_root[static_cast<std::size_t>(child)] = false;
  std::vector<int> roots;
  for (std::size_t i = 0; i < is_root.size(); ++i)
    if (is_root[i]) roots.push_back(static_cast<int>(i));
  for (const std::uint32_t i : parents_first(document, roots)) {
    if (!(stretch[i].scale <= kMaxReach && stretch[i].offset <= kMaxReach))
      return fail(Fault::OutOfRange, node_label(document, i) + " reaches further than 1e12 m");
    for (const int number : document.nodes[i].children) {
      Stretch& child = at(stretch, number);
      child.offset = stretch[i].offset + stretch[i].scale * child.offset;
      child.scale *= stretch[i].scale;
    }
  }
  return {};
}

}  // namespace farshade::gltf
