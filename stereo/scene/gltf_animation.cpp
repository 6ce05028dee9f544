#include "stereo/scene/gltf_animation.h"

#include <set>

#include "stereo/scene/gltf_accessor.h"
#include "stereo/scene/scene_state.h"

namespace farshade::gltf {
namespace {

Path path_from(const std::string& path) {
  return path == "translation" ? Path::Translation : path == "rotation" ? Path::Rotation : Path::Scale;
}

Interpolation interpolation_from(const std::string& name) {
  return name == "STEP"     ? Interpolation::Step
         : name == "LINEAR" ? Interpolation::Linear
                            : Interpolation::CubicSpline;
}

Channel channel_from(const Document& document, const AnimationSampler& sampler, std::uint32_t node,
                     Path path) {
  Channel channel{
      node, path, interpolation_from(sampler.interpolation), read_scalars(document, sampler.input), {}};
  channel.values = read_vectors<4>(document, sampler.output);
  if (path != Path::Rotation)
    for (glm::vec4& value : channel.values) value.w = 0.0f;
  return channel;
}

/// The value at the first key.
glm::dvec4 first_value(const Channel& channel) {
  return glm::dvec4(channel.values[channel.interpolation == Interpolation::CubicSpline ? 1 : 0]);
}

bool is_constant(const Channel& channel) {
  if (channel.keys_s.size() == 1) return true;
  const glm::vec4 first(first_value(channel));
  const bool is_cubic = channel.interpolation == Interpolation::CubicSpline;
  for (std::size_t i = 0; i < channel.values.size(); ++i)
    if (channel.values[i] != (is_cubic && i % 3 != 1 ? glm::vec4(0.0f) : first)) return false;
  return true;
}

}  // namespace

void add_animations(const Document& document, const std::vector<Index>& scene_node, Scene& scene) {
  std::set<std::pair<std::uint32_t, Path>> taken;
  double length_s = 0;
  bool morphs = false;
  for (const Animation& animation : document.animations)
    for (const AnimationChannel& from : animation.channels) {
      if (from.path == "weights") {
        morphs = true;
        continue;
      }
      const Index node = scene_node[from.node];
      const Path path = path_from(from.path);
      if (!node || !taken.emplace(*node, path).second) continue;
      Channel channel = channel_from(document, animation.samplers[from.sampler], *node, path);
      length_s = std::max(length_s, double{channel.keys_s.back()});
      if (is_constant(channel)) {
        set(path, first_value(channel), scene.nodes[*node].rest);
      } else {
        scene.nodes[*node].moving = true;
        scene.channels.push_back(std::move(channel));
      }
    }
  if (morphs) scene.warnings.emplace_back("morph targets stand still, with the weights of the file");
  if (!scene.channels.empty()) scene.animation_length_s = length_s;
  for (farshade::Node& node : scene.nodes)
    if (node.parent && scene.nodes[*node.parent].moving) node.moving = true;
}

}  // namespace farshade::gltf
