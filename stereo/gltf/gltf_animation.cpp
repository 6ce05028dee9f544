#include "stereo/gltf/gltf_animation.h"

#include <algorithm>
#include <glm/common.hpp>
#include <set>

#include "stereo/gltf/gltf_accessor.h"
#include "stereo/scene/scene_state.h"

namespace farshade::gltf {
namespace {

Path path_from(const std::string& path) {
  return path == "translation" ? Path::Translation
         : path == "rotation"  ? Path::Rotation
         : path == "scale"     ? Path::Scale
                               : Path::Visible;
}

Channel channel_from(const Document& document, const AnimationSampler& sampler, std::uint32_t node,
                     Path path) {
  Channel channel{node,
                  path,
                  path == Path::Visible ? Interpolation::Step : interpolation_from(sampler.interpolation),
                  read_scalars(document, static_cast<std::uint32_t>(sampler.input)),
                  {}};
  channel.values = read_vectors<4>(document, static_cast<std::uint32_t>(sampler.output));
  if (path != Path::Rotation)
    for (glm::vec4& value : channel.values) value.w = 0.0f;
  if (path == Path::Visible)
    for (glm::vec4& value : channel.values) value = {value.x != 0 ? 1.0f : 0.0f, 0, 0, 0};
  return channel;
}

WeightTrack weight_track_from(const Document& document, const AnimationSampler& sampler) {
  WeightTrack track{interpolation_from(sampler.interpolation),
                    read_scalars(document, static_cast<std::uint32_t>(sampler.input)),
                    read_scalars(document, static_cast<std::uint32_t>(sampler.output))};
  for (float& weight : track.values)
    weight = glm::clamp(weight, static_cast<float>(-kMostWeight), static_cast<float>(kMostWeight));
  return track;
}

/// Adds the channel to the scene. Returns its length.
double add_channel(const Document& document, const AnimationSampler& sampler, std::uint32_t node, Path path,
                   Scene& scene) {
  Channel channel = channel_from(document, sampler, node, path);
  const double length_s = channel.keys_s.back();
  if (is_constant(channel)) {
    set(path, glm::dvec4(first_value(channel)), scene.nodes[node].rest);
  } else {
    scene.nodes[node].moving |= path != Path::Visible;
    scene.channels.push_back(std::move(channel));
  }
  return length_s;
}

}  // namespace

Interpolation interpolation_from(const std::string& name) {
  return name == "STEP"     ? Interpolation::Step
         : name == "LINEAR" ? Interpolation::Linear
                            : Interpolation::CubicSpline;
}

WeightTracks add_animations(const Document& document, const std::vector<Index>& scene_node,
                            const AnimatedLights& lights, Scene& scene) {
  WeightTracks tracks;
  std::set<std::pair<std::uint32_t, Path>> taken;
  double length_s = 0;
  for (const Animation& animation : document.animations)
    for (const AnimationChannel& from : animation.channels) {
      const Index node = at(scene_node, from.target_node);
      if (!node) continue;
      const AnimationSampler& sampler = at(animation.samplers, from.sampler);
      if (from.target_path == "weights") {
        const int mesh = at(document.nodes, from.target_node).mesh;
        if (mesh < 0 || targets_of(at(document.meshes, mesh)) == 0) continue;
        const auto [track, is_new] = tracks.try_emplace(static_cast<std::uint32_t>(from.target_node),
                                                        weight_track_from(document, sampler));
        if (is_new) length_s = std::max(length_s, double{track->second.keys_s.back()});
        continue;
      }
      const Path path = path_from(from.target_path);
      if (taken.emplace(*node, path).second)
        length_s = std::max(length_s, add_channel(document, sampler, *node, path, scene));
    }
  bool changes = false;  // some light
  for (const auto& [number, light] : lights) {
    length_s = std::max(length_s, light.length_s);
    changes |= !light.tracks.empty();
  }
  if (!scene.channels.empty() || !tracks.empty() || changes) scene.animation_length_s = length_s;
  for (farshade::Node& node : scene.nodes)
    if (node.parent && scene.nodes[*node.parent].moving) node.moving = true;
  return tracks;
}

}  // namespace farshade::gltf
