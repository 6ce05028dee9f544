#include <algorithm>
#include <cmath>

#include "stereo/gltf/gltf_animation.h"
#include "stereo/gltf/gltf_materials.h"
#include "stereo/gltf/gltf_mesh.h"
#include "stereo/gltf/gltf_stages.h"
#include "stereo/scene/mesh_parts.h"
#include "stereo/scene/scene_state.h"
#include "stereo/scene/sky.h"

namespace farshade::gltf {
namespace {

constexpr double kMaxDistance_m = 1e9;

/// When a node of the scene is shown (KHR_node_visibility).
enum class Shown : std::uint8_t { Never, Sometimes, Always };

/// A scene in the making.
struct Conversion {
  Document& document;
  const SceneLimits& limits;
  Scene scene{};
  std::vector<std::uint32_t> order{};  ///< for each node of the scene, its number in the document
  std::vector<Index> scene_node{};     ///< for each node of the document, its number in the scene
  Moving moving{};
  std::vector<Shown> shown{};                  ///< for each node of the scene
  std::vector<Affine<Stage, Object>> poses{};  ///< of the nodes of the scene at time 0
};

void add_nodes(Conversion& to) {
  to.order = parents_first(to.document, roots_of(to.document));
  to.scene_node.resize(to.document.nodes.size());
  for (std::uint32_t i = 0; i < to.order.size(); ++i) {
    const Node& from = to.document.nodes[to.order[i]];
    to.scene_node[to.order[i]] = i;
    to.scene.nodes.push_back({from.name,
                              {},
                              {translation_of(from), glm::normalize(rotation_of(from)), scale_of(from),
                               matrix_of(from), is_visible(from)}});
  }
  for (std::uint32_t i = 0; i < to.order.size(); ++i)
    for (const int child : to.document.nodes[to.order[i]].children)
      to.scene.nodes[*at(to.scene_node, child)].parent = i;
}

std::vector<Shown> when_shown(const Scene& scene) {
  std::vector<Shown> shown;
  for (const farshade::Node& node : scene.nodes)
    shown.push_back(node.rest.visible ? Shown::Always : Shown::Never);
  for (const Channel& channel : scene.channels)
    if (channel.path == Path::Visible) shown[channel.node] = Shown::Sometimes;
  for (std::size_t i = 0; i < shown.size(); ++i)
    if (const auto parent = scene.nodes[i].parent) shown[i] = std::min(shown[i], shown[*parent]);
  return shown;
}

template <class Vector>
bool is_near(const Vector& point) {
  return lies_within(kMaxDistance_m, point);
}

/// Converts the primitives that have triangles. Returns their indices in Scene::meshes.
std::vector<std::uint32_t> add_mesh(const Mesh& from, MaterialConverter& materials, Conversion& to) {
  std::vector<std::uint32_t> numbers;
  for (const Primitive& primitive : from.primitives) {
    farshade::Mesh mesh = mesh_from(to.document, primitive);
    if (mesh.triangles.empty()) continue;
    mesh.name = from.name;
    mesh.material = materials.material(index_of(primitive.material));
    numbers.push_back(static_cast<std::uint32_t>(to.scene.meshes.size()));
    to.scene.meshes.push_back(std::move(mesh));
  }
  return numbers;
}

/// Adds a mesh that one instance shows; nothing if it has no triangles.
void add_instance(farshade::Mesh mesh, std::uint32_t node, std::optional<std::uint32_t> rig, Scene& scene) {
  if (mesh.triangles.empty()) return;
  scene.instances.push_back({static_cast<std::uint32_t>(scene.meshes.size()), node, rig});
  scene.triangle_count += mesh.triangles.size();
  scene.meshes.push_back(std::move(mesh));
}

/// A primitive as a rig deforms it at time 0. Refuses to deform it beyond 1e9 m.
Expected<farshade::Mesh> deformed_mesh(const Document& document, const Primitive& primitive,
                                       const RigPose& pose, const std::string& name,
                                       MaterialConverter& materials) {
  farshade::Mesh mesh = deformable_mesh_from(document, primitive, !pose.object_from_bind.empty());
  mesh.name = name;
  mesh.material = materials.material(index_of(primitive.material));
  pose_at_start(pose, mesh);
  if (!std::ranges::all_of(mesh.positions, is_near<glm::vec3>))
    return fail(Fault::OutOfRange, "mesh '" + printable(name) + "' is deformed beyond 1e9 m");
  return mesh;
}

/// Where a rig's meshes are placed in the scene, and the number of the rig unless it never moves.
struct RigPlace {
  std::uint32_t node = 0;
  std::optional<std::uint32_t> rig;
};

RigPlace add_rig(const Rig& rig, std::uint32_t node, Conversion& to) {
  Scene& scene = to.scene;
  const auto moves = [&](const Joint& joint) { return scene.nodes[joint.node].moving; };
  if (rig.track || std::ranges::any_of(rig.joints, moves)) {
    scene.rigs.push_back(rig);
    return {rig.joints.empty() ? node : rig.joints[0].node,
            static_cast<std::uint32_t>(scene.rigs.size() - 1)};
  }
  if (rig.joints.empty()) return {node, {}};
  scene.nodes.push_back({"skinned mesh", {}, {.matrix = stage_from_skin(rig, to.poses).matrix}});
  return {static_cast<std::uint32_t>(scene.nodes.size() - 1), {}};
}

/// Adds the meshes that one rig deforms. If nothing of the rig ever moves, they are like any other mesh.
void add_deformed(const Mesh& mesh, std::uint32_t node, const Rig& rig, MaterialConverter& materials,
                  Conversion& to) {
  const RigPose pose = pose_of(to.scene, rig, to.poses, Time{});
  const RigPlace place = add_rig(rig, node, to);
  for (const Primitive& primitive : mesh.primitives) {
    auto deformed = deformed_mesh(to.document, primitive, pose, mesh.name, materials);
    if (!deformed) {
      to.document.repairs.add(kNotDrawn, deformed.error());
    } else if (place.rig) {
      for (farshade::Mesh& part : parts_of(std::move(*deformed)))
        add_instance(std::move(part), place.node, place.rig, to.scene);
    } else {
      deformed->deformable.reset();
      remove_without_area(*deformed);
      add_instance(std::move(*deformed), place.node, {}, to.scene);
    }
  }
}

/// The nodes that a scale of 0 hides: their own, on at least two axes, or that of a node above them. A node
/// whose scale is animated is not among them. Below a hidden node, further scales of 0 would only make
/// numbers too small for the lights there, so they become 1.
std::vector<bool> hidden_nodes(Scene& scene) {
  std::vector<bool> hidden(scene.nodes.size());
  for (std::size_t i = 0; i < hidden.size(); ++i) {
    const glm::dvec3& scale = scene.nodes[i].rest.scale;
    hidden[i] = (scale.x == 0) + (scale.y == 0) + (scale.z == 0) >= 2;
  }
  for (const Channel& channel : scene.channels)
    if (channel.path == Path::Scale) hidden[channel.node] = false;
  for (std::size_t i = 0; i < hidden.size(); ++i) {
    const auto parent = scene.nodes[i].parent;
    if (!parent || !hidden[*parent]) continue;
    if (hidden[i]) scene.nodes[i].rest.scale = glm::dvec3(1.0);
    hidden[i] = true;
  }
  return hidden;
}

/// Meshes that a rig deforms are converted for each node alone.
Checked add_instances(Conversion& to) {
  Document& document = to.document;
  Scene& scene = to.scene;
  MaterialConverter materials(document, to.limits, scene);
  std::vector<std::optional<std::vector<std::uint32_t>>> converted(document.meshes.size());
  const auto still = static_cast<std::uint32_t>(scene.nodes.size());
  if (!document.skins.empty()) scene.nodes.emplace_back().name = "joints that are not in the scene";
  const std::vector<bool> hidden = hidden_nodes(scene);
  to.poses = stage_from_nodes(scene, Time{});
  for (std::uint32_t node = 0; node < to.order.size(); ++node) {
    const std::uint32_t number = to.order[node];
    const Node& from = document.nodes[number];
    if (from.mesh < 0 || to.shown[node] == Shown::Never || (hidden[node] && from.skin < 0)) continue;
    const Mesh& mesh = at(document.meshes, from.mesh);
    const std::size_t first = scene.instances.size();
    if (deforms(document, number, to.moving.weights)) {
      const Rig rig = rig_of(document, number, to.scene_node, still, to.moving.weights);
      add_deformed(mesh, node, rig, materials, to);
    } else {
      auto& shared = at(converted, from.mesh);
      if (!shared) shared = add_mesh(mesh, materials, to);
      for (const std::uint32_t index : *shared) {
        scene.instances.push_back({.mesh = index, .node = node});
        scene.triangle_count += scene.meshes[index].triangles.size();
      }
    }
    if (to.shown[node] == Shown::Sometimes)
      for (std::size_t i = first; i < scene.instances.size(); ++i) scene.instances[i].shown_with = node;
  }
  if (scene.instances.empty()) return document.repairs.nothing_to_draw("the scene has no triangles");
  return {};
}

/// Sorts the lights by their index in the file, then by the node that carries them.
Checked add_lights(Conversion& to) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> uses;  // light, document node
  for (std::uint32_t i = 0; i < to.order.size(); ++i)
    if (const Index light = light_of(to.document.nodes[to.order[i]]); light && to.shown[i] != Shown::Never)
      uses.emplace_back(*light, to.order[i]);
  if (uses.size() > to.limits.lights)
    return fail(Fault::OutOfRange, std::to_string(uses.size()) + " lights, at most " +
                                       std::to_string(to.limits.lights) + " can be told apart");
  std::ranges::sort(uses);
  for (const auto& [light, number] : uses) {
    const std::uint32_t node = *to.scene_node[number];
    to.scene.lights.push_back(light_from(to.moving.lights[light], node));
    to.scene.lights.back().hides = to.shown[node] == Shown::Sometimes;
  }
  return {};
}

/// The pose of a node without scale and shear. The z axis keeps its direction; the y axis stays in the plane
/// of the old y and z axes.
Rigid<Stage, Eye> rigid_part(const Affine<Stage, Object>& pose) {
  const glm::dvec3 back = glm::normalize(glm::dvec3(pose.matrix[2]));
  const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(pose.matrix[1]), back));
  const glm::dmat3 axes(right, glm::cross(back, right), back);
  return {glm::normalize(glm::quat_cast(axes)), glm::dvec3(pose.matrix[3])};
}

/// Removes lights and the camera if they are too far away, or below scales whose product is too small for a
/// double, so that they have no direction.
void remove_lost(std::span<const Affine<Stage, Object>> poses, Repairs& repairs, Scene& scene) {
  const auto is_lost = [&](const LightSource& light) {
    const glm::dmat4& pose = poses[light.node].matrix;
    const bool is_far = light.kind != LightKind::Directional && !is_near(glm::dvec3(pose[3]));
    return is_far || (light.kind != LightKind::Point && !(glm::length(glm::dvec3(pose[2])) > 1e-150));
  };
  constexpr const char* kLost = " lies more than 1e9 m from the origin, or is scaled to nothing";
  if (std::erase_if(scene.lights, is_lost) > 0) repairs.add("it is left out", std::string("a light") + kLost);
  if (!scene.camera) return;
  if (is_near(scene.camera->translation) && std::isfinite(glm::length(scene.camera->rotation))) return;
  repairs.add("it is left out", std::string("the camera") + kLost);
  scene.camera.reset();
}

Checked add_places(Conversion& to) {
  Scene& scene = to.scene;
  if (to.document.camera) scene.camera = rigid_part(to.poses[*to.scene_node[*to.document.camera]]);
  remove_lost(to.poses, to.document.repairs, scene);
  const auto places = places_at_start(scene);
  scene.bounds = kNoPoint;
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Bounds object = bounds_of(scene.meshes[scene.instances[i].mesh].positions);
    scene.bounds = joined(scene.bounds, moved(places[i].matrix, object));
  }
  if (is_near(scene.bounds.low) && is_near(scene.bounds.high)) return {};
  return fail(Fault::OutOfRange, "the scene lies more than 1e9 m from the origin");
}

}  // namespace

Expected<Scene> convert(Document& document, const SceneLimits& limits) {
  Conversion to{document, limits};
  Scene& scene = to.scene;
  scene.warnings = document.warnings;
  scene.contents = contents_of(document);
  add_nodes(to);
  to.moving = add_animations(document, to.scene_node, scene);
  to.shown = when_shown(scene);
  const Checked checked =
      add_instances(to).and_then([&] { return add_lights(to); }).and_then([&] { return add_places(to); });
  if (!checked) return tl::unexpected(checked.error());
  const std::vector<std::string> repairs = document.repairs.sentences();
  scene.warnings.insert(scene.warnings.end(), repairs.begin(), repairs.end());
  remove_needless_alpha_tests(scene);
  find_sky(scene);
  return std::move(to.scene);
}

}  // namespace farshade::gltf
