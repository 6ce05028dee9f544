#include "stereo/gltf/gltf_convert.h"

#include <algorithm>
#include <cmath>

#include "stereo/gltf/gltf_animation.h"
#include "stereo/gltf/gltf_choice.h"
#include "stereo/gltf/gltf_materials.h"
#include "stereo/gltf/gltf_mesh.h"
#include "stereo/gltf/gltf_validate.h"
#include "stereo/scene/mesh_parts.h"
#include "stereo/scene/scene_state.h"
#include "stereo/scene/sky.h"

namespace farshade::gltf {
namespace {

constexpr double kMaxDistance_m = 1e9;

/// The order of the nodes in the Scene (those of the default scene, parents first), as maps in both
/// directions.
struct NodeOrder {
  std::vector<std::uint32_t> from_document;
  std::vector<Index> to_scene;
};

NodeOrder order_nodes(const Document& document) {
  NodeOrder order{parents_first(document, roots_of(document)), {}};
  order.to_scene.resize(document.nodes.size());
  for (std::uint32_t i = 0; i < order.from_document.size(); ++i) order.to_scene[order.from_document[i]] = i;
  return order;
}

farshade::Node node_from(const Node& from) {
  farshade::Node to;
  to.name = from.name;
  to.rest.matrix = matrix_of(from);
  to.rest.translation = translation_of(from);
  to.rest.scale = scale_of(from);
  to.rest.rotation = glm::normalize(rotation_of(from));
  to.rest.visible = is_visible(from);
  return to;
}

void add_nodes(const Document& document, const NodeOrder& order, Scene& scene) {
  for (const std::uint32_t index : order.from_document)
    scene.nodes.push_back(node_from(document.nodes[index]));
  for (std::uint32_t i = 0; i < order.from_document.size(); ++i)
    for (const int child : document.nodes[order.from_document[i]].children)
      scene.nodes[*at(order.to_scene, child)].parent = i;
}

/// When each node of the scene is shown (KHR_node_visibility).
enum class Shown : std::uint8_t { Never, Sometimes, Always };
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
std::vector<std::uint32_t> add_mesh(const Mesh& from, const Document& document, MaterialConverter& materials,
                                    Scene& scene) {
  std::vector<std::uint32_t> numbers;
  for (const Primitive& primitive : from.primitives) {
    farshade::Mesh mesh = mesh_from(document, primitive);
    if (mesh.triangles.empty()) continue;
    mesh.name = from.name;
    mesh.material = materials.material(index_of(primitive.material));
    numbers.push_back(static_cast<std::uint32_t>(scene.meshes.size()));
    scene.meshes.push_back(std::move(mesh));
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

RigPlace add_rig(const Rig& rig, std::uint32_t node, std::span<const Affine<Stage, Object>> poses,
                 Scene& scene) {
  const bool moves = rig.track || std::ranges::any_of(rig.joints, [&](const Joint& joint) {
                       return scene.nodes[joint.node].moving;
                     });
  if (moves) {
    scene.rigs.push_back(rig);
    return {rig.joints.empty() ? node : rig.joints[0].node,
            static_cast<std::uint32_t>(scene.rigs.size() - 1)};
  }
  if (rig.joints.empty()) return {node, {}};
  scene.nodes.push_back({"skinned mesh", {}, {.matrix = stage_from_skin(rig, poses).matrix}});
  return {static_cast<std::uint32_t>(scene.nodes.size() - 1), {}};
}

/// Adds the meshes that one rig deforms. If nothing of the rig ever moves, they are like any other mesh.
void add_deformed(Document& document, const Node& from, std::uint32_t node, const Rig& rig,
                  std::span<const Affine<Stage, Object>> poses, MaterialConverter& materials, Scene& scene) {
  const RigPose pose = pose_of(scene, rig, poses, Time{});
  const RigPlace place = add_rig(rig, node, poses, scene);
  const Mesh& mesh = at(document.meshes, from.mesh);
  for (const Primitive& primitive : mesh.primitives) {
    auto deformed = deformed_mesh(document, primitive, pose, mesh.name, materials);
    if (!deformed) document.repairs.add(kNotDrawn, deformed.error());
    if (!deformed) continue;
    if (place.rig) {
      for (farshade::Mesh& part : parts_of(std::move(*deformed)))
        add_instance(std::move(part), place.node, place.rig, scene);
    } else {
      deformed->deformable.reset();
      remove_without_area(*deformed);
      add_instance(std::move(*deformed), place.node, {}, scene);
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
Checked add_instances(Document& document, const NodeOrder& order, const SceneLimits& limits,
                      const WeightTracks& tracks, const std::vector<Shown>& shown, Scene& scene) {
  MaterialConverter materials(document, limits, scene);
  std::vector<std::optional<std::vector<std::uint32_t>>> converted(document.meshes.size());
  const auto still = static_cast<std::uint32_t>(scene.nodes.size());
  if (!document.skins.empty()) scene.nodes.emplace_back().name = "joints that are not in the scene";
  const std::vector<bool> hidden = hidden_nodes(scene);
  const auto poses = stage_from_nodes(scene, Time{});
  for (std::uint32_t node = 0; node < order.from_document.size(); ++node) {
    const std::uint32_t number = order.from_document[node];
    const Node& from = document.nodes[number];
    if (from.mesh < 0 || shown[node] == Shown::Never || (hidden[node] && from.skin < 0)) continue;
    const std::optional<std::uint32_t> shown_with =
        shown[node] == Shown::Sometimes ? std::optional(node) : std::nullopt;
    if (deforms(document, number, tracks)) {
      const Rig rig = rig_of(document, number, order.to_scene, still, tracks);
      const std::size_t first = scene.instances.size();
      add_deformed(document, from, node, rig, poses, materials, scene);
      for (std::size_t i = first; i < scene.instances.size(); ++i) scene.instances[i].shown_with = shown_with;
      continue;
    }
    auto& shared = at(converted, from.mesh);
    if (!shared) shared = add_mesh(at(document.meshes, from.mesh), document, materials, scene);
    for (const std::uint32_t mesh : *shared) {
      scene.instances.push_back({.mesh = mesh, .node = node, .shown_with = shown_with});
      scene.triangle_count += scene.meshes[mesh].triangles.size();
    }
  }
  if (scene.instances.empty()) return document.repairs.nothing_to_draw("the scene has no triangles");
  return {};
}

/// Sorts the lights by their index in the file, then by the node that carries them.
Checked add_lights(const Document& document, const NodeOrder& order, const SceneLimits& limits,
                   const std::vector<AnimatedLight>& lights, const std::vector<Shown>& shown, Scene& scene) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> uses;  // light, document node
  for (std::uint32_t i = 0; i < order.from_document.size(); ++i)
    if (const Index light = light_of(document.nodes[order.from_document[i]]);
        light && shown[i] != Shown::Never)
      uses.emplace_back(*light, order.from_document[i]);
  if (uses.size() > limits.lights)
    return fail(Fault::OutOfRange, std::to_string(uses.size()) + " lights, at most " +
                                       std::to_string(limits.lights) + " can be told apart");
  std::sort(uses.begin(), uses.end());
  for (const auto& [light, node] : uses) {
    scene.lights.push_back(light_from(lights[light], *order.to_scene[node]));
    scene.lights.back().hides = shown[*order.to_scene[node]] == Shown::Sometimes;
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

/// The chosen camera, otherwise the first node whose name starts with `camera:`, otherwise the first with a
/// camera.
Index camera_node(const Document& document, const NodeOrder& order) {
  if (document.chosen_camera) return order.to_scene[*document.chosen_camera];
  Index found;
  for (std::uint32_t i = 0; i < order.from_document.size(); ++i) {
    const Node& node = document.nodes[order.from_document[i]];
    if (node.name.rfind("camera:", 0) == 0) return i;
    if (!found && node.camera >= 0) found = i;
  }
  return found;
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

Checked add_places(Document& document, const NodeOrder& order, Scene& scene) {
  const auto poses = stage_from_nodes(scene, Time{});
  if (const Index camera = camera_node(document, order)) scene.camera = rigid_part(poses[*camera]);
  remove_lost(poses, document.repairs, scene);
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
  const NodeOrder order = order_nodes(document);
  Scene scene;
  scene.warnings = document.warnings;
  scene.contents = contents_of(document);
  add_nodes(document, order, scene);
  const Moving moving = add_animations(document, order.to_scene, scene);
  const std::vector<Shown> shown = when_shown(scene);
  const Checked checked =
      add_instances(document, order, limits, moving.weights, shown, scene)
          .and_then([&] { return add_lights(document, order, limits, moving.lights, shown, scene); })
          .and_then([&] { return add_places(document, order, scene); });
  if (!checked) return tl::unexpected(checked.error());
  const std::vector<std::string> repairs = document.repairs.sentences();
  scene.warnings.insert(scene.warnings.end(), repairs.begin(), repairs.end());
  remove_needless_alpha_tests(scene);
  find_sky(scene);
  return scene;
}

}  // namespace farshade::gltf
