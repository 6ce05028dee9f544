/// Validation of animations: the keys of a sampler increase and its values fit the animated property.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "stereo/scene/gltf_accessor.h"
#include "stereo/scene/gltf_validate.h"

namespace farshade::gltf {
namespace {

constexpr float kMaxTime_s = 1e6f, kMostCone_rad = std::numbers::pi_v<float> / 2 + 1e-6f;

Checked check_keys(const Document& document, const std::string& name, std::uint32_t index) {
  const std::string subject = name + ": key " + label("accessor", index);
  if (index >= document.accessors.size()) return malformed(subject + " is not there");
  const Accessor& accessor = document.accessors[index];
  if (accessor.component != Component::Float || accessor.rows != 1 || accessor.columns != 1)
    return malformed(subject + " should hold float scalars");
  const auto keys = read_scalars(document, index);
  if (std::adjacent_find(keys.begin(), keys.end(), std::greater_equal<>()) != keys.end())
    return malformed(subject + ": its times should grow");
  if (keys.front() < 0.0f || keys.back() > kMaxTime_s)
    return fail(Fault::OutOfRange, subject + ": its times should lie within 0 and 1e6 s");
  return {};
}

Checked check_values(const Document& document, const std::string& name, const AnimationSampler& sampler,
                     bool is_rotation) {
  const std::string subject = name + ": value " + label("accessor", sampler.output);
  if (sampler.output >= document.accessors.size()) return malformed(subject + " is not there");
  const Accessor& accessor = document.accessors[sampler.output];
  const bool is_float = accessor.component == Component::Float;
  const bool fits =
      is_float || (is_rotation && accessor.normalized && accessor.component != Component::UInt32);
  if (!fits || accessor.columns != 1 || accessor.rows != (is_rotation ? 4u : 3u))
    return malformed(subject + " has a type that its path cannot have");
  const std::uint64_t keys = document.accessors[sampler.input].count;
  const std::uint64_t values_a_key = sampler.interpolation == "CUBICSPLINE" ? 3 : 1;
  if (accessor.count != keys * values_a_key)
    return malformed(subject + " has " + std::to_string(accessor.count) + " elements, should have " +
                     std::to_string(keys * values_a_key));
  if (!is_rotation) return {};
  const auto values = read_vectors<4>(document, sampler.output);
  for (std::size_t i = values_a_key / 2; i < values.size(); i += values_a_key)
    if (std::abs(glm::length(values[i]) - 1.0f) > 0.05f)
      return malformed(subject + ": element " + std::to_string(i) + " is not a unit quaternion");
  return {};
}

/// The weights of morph targets: numbers, as many a key as the node's mesh has targets.
Checked check_weights(const Document& document, const std::string& name, const AnimationSampler& sampler,
                      const Node& node) {
  const std::uint64_t targets = node.mesh ? document.meshes[*node.mesh].targets() : 0;
  if (targets == 0) return {};  // nothing of it is read
  const std::string subject = name + ": value " + label("accessor", sampler.output);
  if (sampler.output >= document.accessors.size()) return malformed(subject + " is not there");
  const Accessor& accessor = document.accessors[sampler.output];
  const bool fits = accessor.component == Component::Float ||
                    (accessor.normalized && accessor.component != Component::UInt32);
  if (!fits || accessor.columns != 1 || accessor.rows != 1)
    return malformed(subject + " has a type that weights cannot have");
  const std::uint64_t parts = sampler.interpolation == "CUBICSPLINE" ? 3 : 1;
  const std::uint64_t wanted = document.accessors[sampler.input].count * parts * targets;
  if (accessor.count == wanted) return {};
  return malformed(subject + " has " + std::to_string(accessor.count) + " elements, should have " +
                   std::to_string(wanted));
}

/// Whether a light's property may have this value.
bool may_be(const std::string& property, const glm::vec4& value) {
  if (property == "color") return std::min({value.x, value.y, value.z}) >= 0;
  if (property == "range") return value.x > 0;
  if (property == "spot/innerConeAngle") return value.x >= 0 && value.x < kMostCone_rad;
  if (property == "spot/outerConeAngle") return value.x > 0 && value.x <= kMostCone_rad;
  return value.x >= 0;  // intensity
}

/// The values of a light's property: numbers within its limits, or colours.
Checked check_light_values(const Document& document, const std::string& name, const AnimationSampler& sampler,
                           const std::string& property) {
  const std::string subject = name + ": value " + label("accessor", sampler.output);
  if (sampler.output >= document.accessors.size()) return malformed(subject + " is not there");
  const Accessor& accessor = document.accessors[sampler.output];
  const bool fits = accessor.component == Component::Float ||
                    (accessor.normalized && accessor.component != Component::UInt32);
  if (!fits || accessor.columns != 1 || accessor.rows != (property == "color" ? 3u : 1u))
    return malformed(subject + " has a type that " + property + " of a light cannot have");
  const std::uint64_t parts = sampler.interpolation == "CUBICSPLINE" ? 3 : 1;
  const std::uint64_t wanted = document.accessors[sampler.input].count * parts;
  if (accessor.count != wanted)
    return malformed(subject + " has " + std::to_string(accessor.count) + " elements, should have " +
                     std::to_string(wanted));
  const auto values = read_vectors<4>(document, sampler.output);
  for (std::size_t i = parts / 2; i < values.size(); i += parts)
    if (!may_be(property, values[i]))
      return malformed(subject + ": element " + std::to_string(i) + " is a value that " + property +
                       " of a light cannot have");
  return {};
}

Checked check_sampler(const Document& document, const std::string& name, const Animation& animation,
                      std::uint32_t index) {
  if (index >= animation.samplers.size()) return malformed(name + ": there is no " + label("sampler", index));
  const AnimationSampler& sampler = animation.samplers[index];
  if (sampler.interpolation != "LINEAR" && sampler.interpolation != "STEP" &&
      sampler.interpolation != "CUBICSPLINE")
    return malformed(name + ": unknown interpolation '" + printable(sampler.interpolation) + "'");
  return check_keys(document, name, sampler.input);
}

Checked check_channel(const Document& document, const std::string& name, const Animation& animation,
                      const LightChannel& channel) {
  if (channel.light >= document.lights.size())
    return malformed(name + ": there is no " + label("light", channel.light));
  const Light& light = document.lights[channel.light];
  if (channel.property.starts_with("spot/") && light.type != "spot")
    return malformed(name + ": " + label("light", channel.light, light.name) +
                     " is no spot light, so it has no cone");
  return check_sampler(document, name, animation, channel.sampler).and_then([&] {
    return check_light_values(document, name, animation.samplers[channel.sampler], channel.property);
  });
}

Checked check_channel(const Document& document, const std::string& name, const Animation& animation,
                      const AnimationChannel& channel) {
  if (channel.node >= document.nodes.size())
    return malformed(name + ": there is no " + label("node", channel.node));
  if (channel.path != "translation" && channel.path != "rotation" && channel.path != "scale" &&
      channel.path != "weights")
    return malformed(name + ": unknown path '" + printable(channel.path) + "'");
  const Node& node = document.nodes[channel.node];
  if (node.matrix && channel.path != "weights")
    return malformed(name + ": " + label("node", channel.node, node.name) +
                     " has a matrix and cannot be animated");
  return check_sampler(document, name, animation, channel.sampler).and_then([&] {
    const AnimationSampler& sampler = animation.samplers[channel.sampler];
    return channel.path == "weights" ? check_weights(document, name, sampler, node)
                                     : check_values(document, name, sampler, channel.path == "rotation");
  });
}

std::pair<std::uint32_t, std::string> target_of(const AnimationChannel& channel) {
  return {channel.node, channel.path};
}
std::pair<std::uint32_t, std::string> target_of(const LightChannel& channel) {
  return {channel.light, channel.property};
}

/// Checks channels to nodes or to lights. `left`: the elements that all channels together may still read.
template <class Channel>
Checked check_channels(const Document& document, const std::string& name, const Animation& animation,
                       const std::vector<Channel>& channels, std::uint64_t& left) {
  std::set<std::pair<std::uint32_t, std::string>> targets;
  return check_each(channels, [&](std::size_t c, const Channel& channel) -> Checked {
    const std::string of = name + label("channel", c);
    if (auto checked = check_channel(document, of, animation, channel); !checked) return checked;
    if (!targets.emplace(target_of(channel)).second)
      return malformed(of + ": an earlier channel moves the same property");
    const AnimationSampler& sampler = animation.samplers[channel.sampler];
    const auto elements = document.accessors[sampler.input].count + document.accessors[sampler.output].count;
    if (elements > left)
      return fail(Fault::OutOfRange, of + ": more keys than a file of this size should have");
    left -= elements;
    return {};
  });
}

}  // namespace

Checked validate_animations(const Document& document) {
  std::uint64_t left = element_budget(document);
  return check_each(document.animations, [&](std::size_t a, const Animation& animation) {
    const std::string name = label("animation", a, animation.name) + ", ";
    return check_channels(document, name, animation, animation.channels, left).and_then([&] {
      return check_channels(document, name + "light ", animation, animation.lights, left);
    });
  });
}

}  // namespace farshade::gltf
