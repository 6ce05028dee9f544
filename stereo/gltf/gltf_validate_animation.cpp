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
  const auto accessor = accessor_at(document, name + ": key", index);
  if (!accessor) return tl::unexpected(accessor.error());
  const std::string subject = name + ": key " + label("accessor", index);
  if (component_of(**accessor) != Component::Float || !has_shape(**accessor, 1))
    return malformed(subject + " should hold float scalars");
  const auto keys = read_scalars(document, static_cast<std::uint32_t>(index));
  if (std::adjacent_find(keys.begin(), keys.end(), std::greater_equal<>()) != keys.end())
    return malformed(subject + ": its times should grow");
  if (keys.front() < 0.0f || keys.back() > kMaxTime_s)
    return malformed(subject + ": its times should lie within 0 and 1e6 s");
  return {};
}

/// What a sampler's values must be: `rows` numbers, `values_a_key` times for each key (three times as many
/// for cubic splines), floats or, with `integers`, normalised integers. `of` names what has such values.
struct Values {
  std::string of;
  std::uint32_t rows = 1;
  std::uint64_t values_a_key = 1;
  bool integers = false;
};

Checked check_output(const Document& document, const std::string& name, const AnimationSampler& sampler,
                     const Values& expected) {
  const auto found = accessor_at(document, name + ": value", sampler.output);
  if (!found) return tl::unexpected(found.error());
  const Accessor& accessor = **found;
  const std::string subject = name + ": value " + label("accessor", sampler.output);
  const Component component = component_of(accessor);
  const bool fits = component == Component::Float ||
                    (expected.integers && accessor.normalized && component != Component::UInt32);
  if (!fits || !has_shape(accessor, expected.rows))
    return malformed(subject + " has a type that " + expected.of + " cannot have");
  const std::uint64_t keys = at(document.accessors, sampler.input).count;
  const std::uint64_t wanted = keys * parts_of(sampler) * expected.values_a_key;
  if (accessor.count == wanted) return {};
  return malformed(subject + " has " + std::to_string(accessor.count) + " elements, should have " +
                   std::to_string(wanted));
}

/// Calls `is_right(value)` for the values of a sampler, without the tangents of cubic splines.
template <class IsRight>
Checked check_each_value(const Document& document, const std::string& subject,
                         const AnimationSampler& sampler, const std::string& is_wrong, IsRight is_right) {
  const auto values = read_vectors<4>(document, static_cast<std::uint32_t>(sampler.output));
  for (std::size_t i = parts_of(sampler) / 2; i < values.size(); i += parts_of(sampler))
    if (!is_right(values[i])) return malformed(subject + ": element " + std::to_string(i) + is_wrong);
  return {};
}

Checked check_values(const Document& document, const std::string& name, const AnimationSampler& sampler,
                     bool is_rotation) {
  const std::string subject = name + ": value " + label("accessor", sampler.output);
  const Values expected{.of = "its path", .rows = is_rotation ? 4u : 3u, .integers = is_rotation};
  return check_output(document, name, sampler, expected).and_then([&] {
    return is_rotation ? check_each_value(document, subject, sampler, " is not a unit quaternion",
                                          [](const glm::vec4& value) {
                                            return std::abs(glm::length(value) - 1.0f) <= 0.05f;
                                          })
                       : Checked{};
  });
}

/// The weights of morph targets: numbers, as many a key as the node's mesh has targets.
Checked check_weights(const Document& document, const std::string& name, const AnimationSampler& sampler,
                      const Node& node) {
  const std::uint64_t targets = node.mesh < 0 ? 0 : targets_of(at(document.meshes, node.mesh));
  if (targets == 0)  // nothing of it is read
    return accessor_at(document, name + ": value", sampler.output).map([](const Accessor*) {});
  return check_output(document, name, sampler, {.of = "weights", .values_a_key = targets, .integers = true});
}

/// Booleans, as KHR_animation_pointer asks for them.
Checked check_visibility(const Document& document, const std::string& name, const AnimationSampler& sampler) {
  const std::string subject = name + ": value " + label("accessor", sampler.output);
  if (!points_into(document.accessors, sampler.output)) return malformed(subject + " is not there");
  const Accessor& accessor = at(document.accessors, sampler.output);
  if (sampler.interpolation == "STEP" && component_of(accessor) == Component::UInt8 &&
      has_shape(accessor, 1) && accessor.count == at(document.accessors, sampler.input).count)
    return {};
  return malformed(subject + " should have an unsigned byte for each key, with interpolation STEP");
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
  const std::string subject = name + ": value " + label("accessor", sampler.output),
                    owner = property + " of a light";
  const Values expected{.of = owner, .rows = property == "color" ? 3u : 1u, .integers = true};
  return check_output(document, name, sampler, expected).and_then([&] {
    return check_each_value(document, subject, sampler, " is a value that " + owner + " cannot have",
                            [&](const glm::vec4& value) { return may_be(property, value); });
  });
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
    return check_light_values(document, name, animation.samplers[channel.sampler], channel.property);
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
    return path == "weights"      ? check_weights(document, name, sampler, node)
           : path == kVisiblePath ? check_visibility(document, name, sampler)
                                  : check_values(document, name, sampler, path == "rotation");
  });
}

std::pair<std::uint32_t, std::string> target_of(const AnimationChannel& channel) {
  return {static_cast<std::uint32_t>(channel.target_node), channel.target_path};
}
std::pair<std::uint32_t, std::string> target_of(const LightChannel& channel) {
  return {channel.light, channel.property};
}

/// The elements that a channel reads.
std::uint64_t elements_of(const Document& document, const Animation& animation, int sampler) {
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
    const std::uint64_t elements = elements_of(document, animation, static_cast<int>(channel.sampler));
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
