#include <map>

#include "stereo/gltf/gltf_accessor.h"
#include "stereo/gltf/gltf_stages.h"

namespace farshade::gltf {
namespace {

/// The number of instances: each attribute has one value for each of them.
Expected<std::uint64_t> check_instances(const Document& document, const std::string& name,
                                        const tinygltf::Value& attributes) {
  std::optional<std::uint64_t> count;
  constexpr std::pair<const char*, Elements> kAttributes[] = {
      {"TRANSLATION", {kFloats, 3}}, {"ROTATION", {kFloats | kNormalizedSigned, 4}}, {"SCALE", {kFloats, 3}}};
  for (const auto& [semantic, elements] : kAttributes) {
    const Index index = index_member(&attributes, semantic);
    if (!index) continue;
    const auto found = attribute_of(document, name + ": instance", *index, elements, count, "instances");
    if (!found) return tl::unexpected(found.error());
    count = (*found)->count;
  }
  return count.value_or(1);
}

/// As glTF writes a rotation: x, y, z, w.
std::vector<double> rotation_from(const glm::vec4& v) {
  const glm::dquat q(v.w, v.x, v.y, v.z);
  const glm::dquat unit = glm::length(q) > 1e-6 ? glm::normalize(q) : glm::dquat(1, 0, 0, 0);
  return {unit.x, unit.y, unit.z, unit.w};
}

/// One child of `parent` for each instance.
std::vector<Node> instances_of(const Document& document, const Node& parent,
                               const tinygltf::Value& attributes, std::uint64_t count) {
  const auto places = read_vectors<3>(document, index_member(&attributes, "TRANSLATION")),
             sizes = read_vectors<3>(document, index_member(&attributes, "SCALE"));
  const auto turns = read_vectors<4>(document, index_member(&attributes, "ROTATION"));
  std::vector<Node> made;
  for (std::size_t i = 0; i < count; ++i) {
    if (!sizes.empty() && (sizes[i].x == 0) + (sizes[i].y == 0) + (sizes[i].z == 0) >= 2) continue;
    Node& node = made.emplace_back();
    node.name = parent.name;
    node.mesh = parent.mesh;
    node.weights = parent.weights;
    if (!places.empty()) node.translation = {places[i].x, places[i].y, places[i].z};
    if (!turns.empty()) node.rotation = rotation_from(turns[i]);
    if (!sizes.empty()) node.scale = {sizes[i].x, sizes[i].y, sizes[i].z};
  }
  return made;
}

/// The channels that animate the weights of nodes: animation and sampler, by node.
using WeightChannels = std::multimap<std::size_t, std::pair<std::size_t, int>>;

WeightChannels weight_channels(const Document& document) {
  WeightChannels result;
  for (std::size_t a = 0; a < document.animations.size(); ++a)
    for (const AnimationChannel& channel : document.animations[a].channels)
      if (channel.target_path == "weights")
        result.emplace(static_cast<std::size_t>(channel.target_node), std::pair(a, channel.sampler));
  return result;
}

/// Animates the weights of all nodes from `first` on like those of `node`, whose instances they are.
void share_weights(const WeightChannels& channels, std::size_t node, std::size_t first, Document& document) {
  const auto [begin, end] = channels.equal_range(node);
  for (auto channel = begin; channel != end; ++channel)
    for (std::size_t instance = first; instance < document.nodes.size(); ++instance) {
      AnimationChannel& added = document.animations[channel->second.first].channels.emplace_back();
      added.sampler = channel->second.second;
      added.target_node = static_cast<int>(instance);
      added.target_path = "weights";
    }
}

}  // namespace

Checked expand_instances(Document& document) {
  // Of all nodes together: 2^16, and one for each four bytes of the buffers.
  Budget left((std::uint64_t{1} << 16) + buffer_bytes(document) / 4);
  const std::size_t nodes = document.nodes.size();  // of the file
  const WeightChannels channels = weight_channels(document);
  for (std::size_t i = 0; i < nodes; ++i) {
    const Node& node = document.nodes[i];
    const auto* attributes = member(extension(node.extensions, "EXT_mesh_gpu_instancing"), "attributes");
    if (!attributes || node.mesh < 0 || node.skin >= 0) continue;  // a skin has the place of its joints
    const std::string name = label("node", i, node.name);
    const auto count = check_instances(document, name, *attributes);
    if (!count) document.repairs.add("its mesh is drawn once", count.error());
    if (!count) continue;
    // What each instance has besides its place: its name, the weights, and channels that move them.
    const std::uint64_t each = 1 + node.name.size() / 64 + node.weights.size() / 16 + channels.count(i) / 8;
    const Checked taken =
        left.take(*count * each, name + ": " + std::to_string(*count) +
                                     " instances are more than a file of this size should have");
    if (!taken) return taken;
    const std::size_t first = document.nodes.size();
    std::vector<Node> made = instances_of(document, node, *attributes, *count);
    for (Node& instance : made) {
      document.nodes[i].children.push_back(static_cast<int>(document.nodes.size()));
      document.nodes.push_back(std::move(instance));
    }
    share_weights(channels, i, first, document);
    document.nodes[i].mesh = -1;
    document.nodes[i].weights.clear();
  }
  return {};
}

}  // namespace farshade::gltf
