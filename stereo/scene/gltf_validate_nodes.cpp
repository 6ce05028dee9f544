/// Validation of the nodes (a forest), their transforms, and the scenes.
#include <cmath>

#include "stereo/scene/gltf_accessor.h"
#include "stereo/scene/gltf_validate.h"

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

bool animates_scale_of(const Document& document, std::size_t node) {
  for (const Animation& animation : document.animations)
    for (const AnimationChannel& channel : animation.channels)
      if (channel.node == node && channel.path == "scale") return true;
  return false;
}

Checked check_transform(const Document& document, std::size_t index, const Node& node) {
  const std::string name = node_label(document, index);
  if (node.matrix) return check_matrix(name, *node.matrix);
  if (node.rotation && std::abs(glm::length(*node.rotation) - 1.0) > 0.01)
    return malformed(name + ": its rotation is not a unit quaternion");
  const bool is_flat = node.scale && (node.scale->x == 0 || node.scale->y == 0 || node.scale->z == 0);
  if (is_flat && !animates_scale_of(document, index))
    return malformed(name + ": its scale is 0 and cannot be inverted");
  return {};
}

Checked check_references(const Document& document, std::size_t index, const Node& node) {
  const std::string name = node_label(document, index);
  if (!points_into(document.meshes, node.mesh))
    return malformed(name + ": there is no " + label("mesh", *node.mesh));
  if (!points_into(document.lights, node.light))
    return malformed(name + ": there is no " + label("light", *node.light));
  if (node.camera && *node.camera >= document.cameras.size())
    return malformed(name + ": there is no " + label("camera", *node.camera));
  if (!points_into(document.skins, node.skin))
    return malformed(name + ": there is no " + label("skin", *node.skin));
  return {};
}

/// Checks that every child exists and has one parent. Fills `parents`.
Checked check_children(const Document& document, std::vector<Index>& parents) {
  return check_each(document.nodes, [&](std::size_t i, const Node& node) -> Checked {
    for (const std::uint32_t child : node.children) {
      if (child >= document.nodes.size())
        return malformed(node_label(document, i) + ": there is no child " + label("node", child));
      if (parents[child])
        return malformed(node_label(document, child) + " has two parents, " + label("node", *parents[child]) +
                         " and " + label("node", i));
      parents[child] = static_cast<std::uint32_t>(i);
    }
    return {};
  });
}

/// Every node has at most one parent here, so a node that no root reaches is part of a cycle or below one.
Checked check_forest(const Document& document, const std::vector<Index>& parents, std::uint32_t most_depth) {
  std::vector<std::uint32_t> roots;
  for (std::uint32_t i = 0; i < parents.size(); ++i)
    if (!parents[i]) roots.push_back(i);
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
  if (!points_into(document.scenes, document.default_scene))
    return malformed("the default " + label("scene", *document.default_scene) + " is not there");
  return check_each(document.scenes, [&](std::size_t s, const auto& roots) -> Checked {
    std::vector<bool> seen(document.nodes.size(), false);
    for (const std::uint32_t root : roots) {
      if (root >= document.nodes.size())
        return malformed(label("scene", s) + ": there is no " + label("node", root));
      if (parents[root] || seen[root])
        return malformed(label("scene", s) + ": " + node_label(document, root) +
                         (parents[root] ? " is no root" : " is named twice"));
      seen[root] = true;
    }
    return {};
  });
}

/// Upper bounds for a node: the factor by which it scales lengths, and the distance of its origin.
struct Stretch {
  double scale = 1, offset = 0;
};

Stretch rest_stretch(const Node& node) {
  if (node.matrix) {
    const glm::dmat4& m = *node.matrix;
    const double squares = glm::dot(m[0], m[0]) + glm::dot(m[1], m[1]) + glm::dot(m[2], m[2]);
    return {std::sqrt(squares), glm::length(glm::dvec3(m[3]))};
  }
  return {glm::length(node.scale.value_or(glm::dvec3(1.0))),
          glm::length(node.translation.value_or(glm::dvec3(0.0)))};
}

/// Upper bound of a cubic spline: its largest value plus its largest tangent times the time between keys.
double largest_output(const Document& document, const AnimationSampler& sampler) {
  double largest = 0;
  for (const glm::vec3 v : read_vectors<3>(document, sampler.output))
    largest = std::max(largest, glm::length(glm::dvec3(v)));
  const bool has_tangents = sampler.interpolation == "CUBICSPLINE";
  return has_tangents ? largest * (1.0 + read_scalars(document, sampler.input).back()) : largest;
}

}  // namespace

std::vector<std::uint32_t> parents_first(const Document& document, const std::vector<std::uint32_t>& roots) {
  std::vector<std::uint32_t> order = roots;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto& children = document.nodes[order[i]].children;
    order.insert(order.end(), children.begin(), children.end());
  }
  return order;
}

Checked validate_nodes(const Document& document, const SceneLimits& limits) {
  std::vector<Index> parents(document.nodes.size());
  return check_each(document.nodes,
                    [&](auto i, const auto& node) { return check_references(document, i, node); })
      .and_then([&] {
        return check_each(document.nodes,
                          [&](auto i, const auto& node) { return check_transform(document, i, node); });
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
      if (channel.path == "rotation" || channel.path == "weights") continue;
      const double largest = largest_output(document, animation.samplers[channel.sampler]);
      double& bound = channel.path == "scale" ? stretch[channel.node].scale : stretch[channel.node].offset;
      bound = std::max(bound, largest);
    }
  std::vector<bool> is_root(document.nodes.size(), true);
  for (const Node& node : document.nodes)
    for (const std::uint32_t child : node.children) is_root[child] = false;
  std::vector<std::uint32_t> roots;
  for (std::uint32_t i = 0; i < is_root.size(); ++i)
    if (is_root[i]) roots.push_back(i);
  for (const std::uint32_t i : parents_first(document, roots)) {
    if (!(stretch[i].scale <= kMaxReach && stretch[i].offset <= kMaxReach))
      return fail(Fault::OutOfRange, node_label(document, i) + " reaches further than 1e12 m");
    for (const std::uint32_t child : document.nodes[i].children) {
      stretch[child].offset = stretch[i].offset + stretch[i].scale * stretch[child].offset;
      stretch[child].scale *= stretch[i].scale;
    }
  }
  return {};
}

}  // namespace farshade::gltf
