/// Validation of animations: the keys of a sampler increase and its values fit the animated property.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "stereo/gltf/gltf_accessor.h"
#include "stereo/gltf/gltf_validate.h"

namespace farshade::gltf {
namespace {

constexpr float kMaxTime_s = 1e6f, kMostCone_rad = std::numbers::pi_v<float> / 2 + 1e-6f;

/// The values of a sampler for each key: a cubic spline also has two tangents.
std::size_t parts_of(const AnimationSampler& sampler) {
  return sampler.interpolation == "CUBICSPLINE" ? 3 : 1;
}

Checked check_keys(const Document& document, const std::string& name, int index) {
  const auto accessor =
      accessor_of(document, name + ": key", index, {kFloats, 1}, "should hold float scalars");
  if (!accessor) return tl::unexpected(accessor.error());
  const std::string subject = name + ": key " + label("accessor", index);
  const auto keys = read_scalars(document, static_cast<std::uint32_t>(index));
  if (std::adjacent_find(keys.begin(), keys.end(), std::greater_equal<>()) != keys.end())
    return malformed(subject + ": its times should grow");
  if (keys.front() < 0.0f || keys.back() > kMaxTime_s)
    return malformed(subject + ": its times should lie within 0 and 1e6 s");
  return {};
}

/// Whether an animated property may have this value.
bool may_be(const std::string& property, const glm::vec4& value) {
  if (property == "rotation") return std::abs(glm::length(value) - 1.0f) <= 0.05f;
  if (property == "color") return std::min({value.x, value.y, value.z}) >= 0;
  if (property == "range") return value.x > 0;
  if (property == "spot/innerConeAngle") return value.x >= 0 && value.x < kMostCone_rad;
  if (property == "spot/outerConeAngle") return value.x > 0 && value.x <= kMostCone_rad;
  return property != "intensity" || value.x >= 0;
}

/// Checks the values of a sampler for `property`: there are `values_a_key` for each key (three times as many
/// for cubic splines), which are floats or normalised integers. KHR_animation_pointer asks for unsigned bytes
/// and STEP where a property is a boolean; other scalars are read as bytes are, other interpolations as STEP.
Checked check_output(const Document& document, const std::string& name, const AnimationSampler& sampler,
                     const std::string& property, std::uint64_t values_a_key = 1) {
  const bool is_vector = property == "translation" || property == "scale", is_flag = property == kVisiblePath;
  const std::uint32_t rows = property == "rotation" ? 4 : is_vector || property == "color" ? 3 : 1;
  const Numbers numbers = is_vector ? kFloats : is_flag ? kFloatsOrShort : kFloatsOrNormalized;
  const auto found = accessor_of(document, name + ": value", sampler.output, {numbers, rows},
                                 "has a type that " + property + " cannot have");
  if (!found) return tl::unexpected(found.error());
  const Accessor& accessor = **found;
  const std::string subject = name + ": value " + label("accessor", sampler.output);
  const std::size_t parts = is_flag ? 1 : parts_of(sampler);
  const std::uint64_t wanted = at(document.accessors, sampler.input).count * parts * values_a_key;
  if (accessor.count != wanted)
    return malformed(subject + " has " + std::to_string(accessor.count) + " elements, should have " +
                     std::to_string(wanted));
  const auto values = read_vectors<4>(document, static_cast<std::uint32_t>(sampler.output));
  for (std::size_t i = parts / 2; i < values.size(); i += parts)  // without tangents
    if (!may_be(property, values[i]))
      return malformed(subject + ": element " + std::to_string(i) + " is a value that " + property +
                       " cannot have");
  return {};
}

/// The weights of morph targets: numbers, as many a key as the node's mesh has targets.
Checked check_weights(const Document& document, const std::string& name, const AnimationSampler& sampler,
                      const Node& node) {
  const std::uint64_t targets = node.mesh < 0 ? 0 : targets_of(at(document.meshes, node.mesh));
  if (targets == 0)  // nothing of it is read
    return accessor_at(document, name + ": value", sampler.output).map([](const Accessor*) {});
  return check_output(document, name, sampler, "weights", targets);
}

Checked check_sampler(const Document& document, const std::string& name, const Animation& animation,
                      int index) {
  if (!points_into(animation.samplers, index))
    return malformed(name + ": there is no " + label("sampler", index));
  const AnimationSampler& sampler = at(animation.samplers, index);
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
  return check_sampler(document, name, animation, static_cast<int>(channel.sampler)).and_then([&] {
    return check_output(document, name, animation.samplers[channel.sampler], channel.property);
  });
}

Checked check_channel(const Document& document, const std::string& name, const Animation& animation,
                      const AnimationChannel& channel) {
  const std::string& path = channel.target_path;
  if (!points_into(document.nodes, channel.target_node))
    return malformed(name + ": there is no " + label("node", channel.target_node));
  if (path != "translation" && path != "rotation" && path != "scale" && path != "weights" &&
      path != kVisiblePath)
    return malformed(name + ": unknown path '" + printable(path) + "'");
  const Node& node = at(document.nodes, channel.target_node);
  if (!node.matrix.empty() && path != "weights" && path != kVisiblePath)
    return malformed(name + ": " + label("node", channel.target_node, node.name) +
                     " has a matrix and cannot be animated");
  return check_sampler(document, name, animation, channel.sampler).and_then([&] {
    const AnimationSampler& sampler = at(animation.samplers, channel.sampler);
    return path == "weights" ? check_weights(document, name, sampler, node)
                             : check_output(document, name, sampler, path);
  });
}

std::pair<std::uint32_t, std::string> target_of(const AnimationChannel& channel) {
  return {static_cast<std::uint32_t>(channel.target_node), channel.target_path};
}
std::pair<std::uint32_t, std::string> target_of(const LightChannel& channel) {
  return {channel.light, channel.property};
}

/// The elements that a channel reads.
std::uint64_t elements_read(const Document& document, const Animation& animation, int sampler) {
  if (sampler < 0 || !points_into(animation.samplers, sampler)) return 0;
  std::uint64_t sum = 0;
  for (const int accessor : {at(animation.samplers, sampler).input, at(animation.samplers, sampler).output})
    if (accessor >= 0 && points_into(document.accessors, accessor))
      sum += at(document.accessors, accessor).count;
  return sum;
}

/// Removes the channels, to nodes or to lights, that have faults. `left`: the elements that all channels
/// together may still read.
template <class Channel>
Checked keep_channels(Document& document, const std::string& name, const Animation& animation,
                      std::vector<Channel>& channels, std::uint64_t& left) {
  std::set<std::pair<std::uint32_t, std::string>> targets;
  std::vector<Channel> kept;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const Channel& channel = channels[c];
    const std::string of = name + label("channel", c);
    const std::uint64_t elements = elements_read(document, animation, static_cast<int>(channel.sampler));
    if (elements > left)
      return fail(Fault::OutOfRange, of + ": more keys than a file of this size should have");
    left -= elements;
    Checked checked = check_channel(document, of, animation, channel);
    if (checked && !targets.emplace(target_of(channel)).second)
      checked = malformed(of + ": an earlier channel moves the same property");
    if (checked)
      kept.push_back(channel);
    else
      document.repairs.add("it stands still", checked.error());
  }
  channels = std::move(kept);
  return {};
}

}  // namespace

Checked validate_animations(Document& document) {
  std::uint64_t left = element_budget(document);
  return check_each(document.animations, [&](std::size_t a, Animation& animation) {
    const std::string name = label("animation", a, animation.name) + ", ";
    return keep_channels(document, name, animation, animation.channels, left).and_then([&] {
      return keep_channels(document, name + "light ", animation, document.light_channels[a], left);
    });
  });
}

}  // namespace farshade::gltf
