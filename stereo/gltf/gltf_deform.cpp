#include "stereo/gltf/gltf_deform.h"

#include <algorithm>
#include <glm/common.hpp>

#include "stereo/gltf/gltf_accessor.h"

namespace farshade::gltf {
namespace {

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

/// Whether each key has the weights of the first one, and no tangents.
bool keeps_weights(const WeightTrack& track, std::size_t targets) {
  const bool is_cubic = track.interpolation == Interpolation::CubicSpline;
  const auto is_value = [&](std::size_t i) { return !is_cubic || i / targets % 3 == 1; };
  const std::size_t first = is_cubic ? targets : 0;
  for (std::size_t i = 0; i < track.values.size(); ++i)
    if (track.values[i] != (is_value(i) ? track.values[first + i % targets] : 0.0f)) return false;
  return true;
}

std::vector<glm::vec3> differences(const Document& document, Index accessor) {
  return accessor ? read_vectors<3>(document, *accessor) : std::vector<glm::vec3>();
}

}  // namespace

bool deforms(const Document& document, const Node& node, std::uint32_t number, const WeightTracks& tracks) {
  if (node.skin >= 0) return true;
  const std::vector<float> weights = weights_of(document, node);
  const bool is_deformed = std::ranges::any_of(weights, [](float weight) { return weight != 0; });
  return is_deformed || (tracks.contains(number) && !weights.empty());
}

Rig rig_of(const Document& document, std::uint32_t number, const std::vector<Index>& scene_node,
           std::uint32_t still, const WeightTracks& tracks) {
  const Node& node = document.nodes[number];
  Rig rig{.joints = {}, .weights = weights_of(document, node)};
  if (node.skin >= 0) rig.joints = joints_of(document, at(document.skins, node.skin), scene_node, still);
  const auto found = tracks.find(number);
  if (found == tracks.end() || rig.weights.empty()) return rig;
  const WeightTrack& track = found->second;
  if (!keeps_weights(track, rig.weights.size())) {
    rig.track = track;
    return rig;
  }
  const std::size_t first = track.interpolation == Interpolation::CubicSpline ? rig.weights.size() : 0;
  for (std::size_t i = 0; i < rig.weights.size(); ++i) rig.weights[i] = track.values[first + i];
  return rig;
}

Deformable deformable_of(const Document& document, const Primitive& primitive, bool skinned) {
  Deformable result{.positions = read_vectors<3>(document, *attribute(primitive, "POSITION"))};
  if (const Index normal = attribute(primitive, "NORMAL"))
    result.normals = read_vectors<3>(document, *normal);
  for (const auto& target : primitive.targets)
    result.targets.push_back({differences(document, attribute(target, "POSITION")),
                              differences(document, attribute(target, "NORMAL"))});
  if (skinned) result.influences = influences_of(document, primitive);
  return result;
}

}  // namespace farshade::gltf
