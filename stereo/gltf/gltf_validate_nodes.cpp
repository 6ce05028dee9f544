/// Validation of the nodes (a forest), their transforms, and the scenes.
#include <cmath>
#include <glm/gtc/matrix_access.hpp>

#include "stereo/gltf/gltf_accessor.h"
#include "stereo/gltf/gltf_stages.h"

namespace farshade::gltf {
namespace {

/// Below this ratio of the determinant to the product of the column lengths, a matrix counts as singular.
constexpr double kLeastRelativeVolume = 1e-10;
/// Largest length, metres, to which the transforms of the nodes may scale one unit of a node's space.
constexpr double kMaxReach = 1e12;

std::string node_label(const Document& document, std::size_t index) {
  return label("node", index, document.nodes[index].name);
}

/// The nodes without a parent.
std::vector<int> all_roots(const std::vector<Index>& parents) {
  std::vector<int> roots;
  for (std::size_t i = 0; i < parents.size(); ++i)
    if (!parents[i]) roots.push_back(static_cast<int>(i));
  return roots;
}

/// Whether a matrix has no volume, so that it cannot be inverted.
bool is_flat(const glm::dmat4& m) {
  const glm::dvec3 x(m[0]), y(m[1]), z(m[2]);
  const double lengths = glm::length(x) * glm::length(y) * glm::length(z);
  const double volume = std::abs(glm::dot(x, glm::cross(y, z)));
  return !(lengths > 0.0) || !(volume > kLeastRelativeVolume * lengths);
}

/// Gives a matrix that flattens along one of its axes a thickness of 1e-9 of its size, nearly as a scale of 0
/// gets (stage_from_nodes). False for other matrices.
bool thicken(glm::dmat4& matrix) {
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 a(matrix[(i + 1) % 3]), b(matrix[(i + 2) % 3]), normal = glm::cross(a, b);
    const double lengths = glm::length(a) * glm::length(b),
                 longest = std::max(glm::length(a), glm::length(b));
    if (glm::dvec3(matrix[i]) != glm::dvec3(0.0) || !(glm::length(normal) > kLeastRelativeVolume * lengths))
      continue;
    matrix[i] = glm::dvec4(glm::normalize(normal) * (1e-9 * longest), 0.0);
    return true;
  }
  return false;
}

/// A matrix without volume becomes a scale of 0, unless it flattens along one axis.
void mend_transform(const std::string& name, Node& node, Repairs& repairs) {
  if (auto matrix = matrix_of(node)) {
    glm::dmat4& m = *matrix;
    const glm::dvec4 last(0, 0, 0, 1);
    if (glm::row(m, 3) != last)
      repairs.add("it counts as that", name + ": the last row of its matrix is not 0 0 0 1");
    m = glm::row(m, 3, last);
    const bool is_usable = !is_flat(m) || thicken(m);
    node.matrix.assign(glm::value_ptr(m), glm::value_ptr(m) + 16);
    if (is_usable) return;
    node.translation = {m[3].x, m[3].y, m[3].z};
    node.scale = {0, 0, 0};
    node.matrix.clear();
  }
  const double length = glm::length(rotation_of(node));
  if (std::abs(length - 1.0) <= 0.01) return;
  repairs.add("it is made one", name + ": its rotation is not a unit quaternion");
  if (length > 1e-6)
    for (double& part : node.rotation) part /= length;
  else
    node.rotation.clear();
}

/// Removes an index that points to nothing.
template <class List>
void keep_reference(const std::string& name, const char* kind, const List& list, int& index,
                    Repairs& repairs) {
  if (points_into(list, index)) return;
  repairs.add("it goes without", name + ": there is no " + label(kind, index));
  index = -1;
}

void keep_references(const Document& document, const std::string& name, Node& node, Repairs& repairs) {
  keep_reference(name, "mesh", document.meshes, node.mesh, repairs);
  keep_reference(name, "camera", document.cameras, node.camera, repairs);
  keep_reference(name, "skin", document.skins, node.skin, repairs);
  const Index light = light_of(node);
  int number = light ? static_cast<int>(*light) : -1;
  keep_reference(name, "light", document.lights, number, repairs);
  if (number < 0 || at(document.lights, number).type.empty()) node.extensions.erase("KHR_lights_punctual");
}

/// Removes children that are not there or have a parent already. Fills `parents`.
void keep_children(Document& document, std::vector<Index>& parents) {
  for (std::size_t i = 0; i < document.nodes.size(); ++i)
    std::erase_if(document.nodes[i].children, [&](int child) {
      if (!points_into(document.nodes, child)) {
        document.repairs.add("it goes without",
                             node_label(document, i) + ": there is no child " + label("node", child));
        return true;
      }
      Index& parent = at(parents, child);
      if (parent)
        document.repairs.add("it stays with the first", label("node", child, at(document.nodes, child).name) +
                                                            " has two parents, " + label("node", *parent) +
                                                            " and " + label("node", i));
      if (parent) return true;
      parent = static_cast<std::uint32_t>(i);
      return false;
    });
}

/// Every node has at most one parent here, so a node that no root reaches is part of a cycle or below one.
Checked check_forest(const Document& document, const std::vector<Index>& parents, std::uint32_t most_depth) {
  std::vector<std::uint32_t> depth(parents.size(), 0);
  for (const std::uint32_t i : parents_first(document, all_roots(parents))) {
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

/// Removes roots of a scene that are not there, are named twice, or hang below another of its roots.
void keep_roots(Document& document, std::size_t number, const std::vector<Index>& parents) {
  std::vector<int>& roots = document.scenes[number].nodes;
  const std::set<int> named(roots.begin(), roots.end());
  std::set<int> seen;
  std::erase_if(roots, [&](int root) {
    const std::string scene = label("scene", number) + ": ";
    if (!points_into(document.nodes, root)) {
      document.repairs.add("it goes without", scene + "there is no " + label("node", root));
      return true;
    }
    const std::string name = scene + label("node", root, at(document.nodes, root).name);
    bool is_drawn = !seen.insert(root).second;
    if (is_drawn || at(parents, root))
      document.repairs.add("it is drawn once", name + (is_drawn ? " is named twice" : " is no root"));
    for (Index above = at(parents, root); above && !is_drawn; above = parents[*above])
      is_drawn = named.contains(static_cast<int>(*above));
    return is_drawn;
  });
}

void mend_scenes(Document& document, const std::vector<Index>& parents) {
  if (document.scenes.empty()) {
    document.scenes.emplace_back().nodes = all_roots(parents);
    document.repairs.add("all nodes are drawn", "the file has no scene");
  }
  if (!points_into(document.scenes, document.defaultScene)) {
    document.repairs.add("the first one is drawn",
                         "the default " + label("scene", document.defaultScene) + " is not there");
    document.defaultScene = 0;
  }
  for (std::size_t i = 0; i < document.scenes.size(); ++i) keep_roots(document, i, parents);
}

/// Upper bounds for a node: the factor by which it scales lengths, and the distance of its origin.
struct Stretch {
  double scale = 1, offset = 0;
};

double largest(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

Stretch rest_stretch(const Node& node) {
  if (const auto matrix = matrix_of(node)) {
    const glm::dmat4& m = *matrix;
    const glm::dmat3 linear(m), squares = glm::transpose(linear) * linear;
    double most = 0;  // the eigenvalues of `squares` are not above this, by Gershgorin
    for (int i = 0; i < 3; ++i) most = std::max(most, glm::dot(glm::abs(squares[i]), glm::dvec3(1.0)));
    return {std::sqrt(most), glm::length(glm::dvec3(m[3]))};
  }
  return {largest(scale_of(node)), glm::length(translation_of(node))};
}

/// Upper bound of a scale or translation. Of a cubic spline: its largest value plus its largest tangent times
/// the time between keys.
double largest_output(const Document& document, const AnimationSampler& sampler, bool is_scale) {
  double most = 0;
  for (const glm::dvec3 v : read_vectors<3>(document, static_cast<std::uint32_t>(sampler.output)))
    most = std::max(most, is_scale ? largest(v) : glm::length(v));
  const bool has_tangents = sampler.interpolation == "CUBICSPLINE";
  if (!has_tangents) return most;
  return most * (1.0 + read_scalars(document, static_cast<std::uint32_t>(sampler.input)).back());
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

Checked validate_nodes(Document& document, const SceneLimits& limits) {
  std::vector<Index> parents(document.nodes.size());
  for (std::size_t i = 0; i < parents.size(); ++i) {
    const std::string name = node_label(document, i);
    keep_references(document, name, document.nodes[i], document.repairs);
    mend_transform(name, document.nodes[i], document.repairs);
  }
  keep_children(document, parents);
  const Checked checked = check_forest(document, parents, limits.node_depth);
  if (checked) mend_scenes(document, parents);
  return checked;
}

Checked validate_reach(const Document& document) {
  std::vector<Stretch> stretch(document.nodes.size());
  for (std::size_t i = 0; i < stretch.size(); ++i) stretch[i] = rest_stretch(document.nodes[i]);
  for (const Animation& animation : document.animations)
    for (const AnimationChannel& channel : animation.channels) {
      if (channel.target_path != "translation" && channel.target_path != "scale") continue;
      const bool is_scale = channel.target_path == "scale";
      const double most = largest_output(document, at(animation.samplers, channel.sampler), is_scale);
      Stretch& of = at(stretch, channel.target_node);
      double& bound = is_scale ? of.scale : of.offset;
      bound = std::max(bound, most);
    }
  for (const std::uint32_t i : parents_first(document, roots_of(document))) {
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
