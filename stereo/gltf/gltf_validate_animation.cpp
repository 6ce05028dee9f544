/// Validation of animations: the keys of a sampler increase and its values fit the animated property.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <set>
#include <tuple>

#include "stereo/gltf/gltf_accessor.h"
#include "stereo/gltf/gltf_stages.h"

namespace farshade::gltf {
namespace {

constexpr float kMaxTime_s = 1e6f, kMostCone_rad = std::numbers::pi_v<float> / 2 + 1e-6f;

bool is_unit(const glm::vec4& value) {
  return std::abs(glm::length(value) - 1.0f) <= 0.05f;
}
bool is_not_negative(const glm::vec4& value) {
  return std::min({value.x, value.y, value.z}) >= 0;
}

/// A property that animations may change: of the nodes or of the lights.
struct Property {
  std::string_view name, list;
  Elements elements;                           ///< of its values
  bool (*may_be)(const glm::vec4&) = nullptr;  ///< a value; components that it does not have are 1
};
constexpr std::string_view kNodes = "/nodes/", kLights = "/extensions/KHR_lights_punctual/lights/";
/// KHR_animation_pointer asks for unsigned bytes where a property is a boolean; other scalars are read as
/// bytes are.
constexpr Property kProperties[] = {
    {"translation", kNodes, {kFloats, 3}},
    {"rotation", kNodes, {kFloatsOrNormalized, 4}, is_unit},
    {"scale", kNodes, {kFloats, 3}},
    {"weights", kNodes, {kFloatsOrNormalized, 1}},
    {kVisiblePath, kNodes, {kFloatsOrShort, 1}},
    {"color", kLights, {kFloatsOrNormalized, 3}, is_not_negative},
    {"intensity", kLights, {kFloatsOrNormalized, 1}, is_not_negative},
    {"range", kLights, {kFloatsOrNormalized, 1}, [](const glm::vec4& value) { return value.x > 0; }},
    {"spot/innerConeAngle",
     kLights,
     {kFloatsOrNormalized, 1},
     [](const glm::vec4& value) { return value.x >= 0 && value.x < kMostCone_rad; }},
    {"spot/outerConeAngle",
     kLights,
     {kFloatsOrNormalized, 1},
     [](const glm::vec4& value) { return value.x > 0 && value.x <= kMostCone_rad; }},
};

/// The property `name` of the elements of `list`; null if there is none.
const Property* property_of(std::string_view list, std::string_view name) {
  const auto* found = std::ranges::find_if(
      kProperties, [&](const Property& one) { return one.list == list && one.name == name; });
  return found == std::end(kProperties) ? nullptr : found;
}

/// Whether `pointer` names a property of an element of `list`, such as "/nodes/3/scale". `channel` becomes
/// one of that property then.
bool resolve(std::string_view pointer, std::string_view list, AnimationChannel& channel) {
  if (!pointer.starts_with(list)) return false;
  pointer.remove_prefix(list.size());
  const auto slash = pointer.find('/');
  if (slash == pointer.npos) return false;
  const Property* const property = property_of(list, pointer.substr(slash + 1));
  const char* const end = pointer.data() + slash;
  std::uint32_t index = 0;
  const auto read = std::from_chars(pointer.data(), end, index);
  if (read.ec != std::errc{} || read.ptr != end || !property) return false;
  channel.target_node = static_cast<int>(std::min(index, kMaxIndex));
  channel.target_path = property->name;
  return true;
}

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

/// Checks the values of a sampler for a property: there are `values_a_key` for each key (three times as many
/// for cubic splines). The interpolation of a boolean is read as STEP.
Checked check_output(const Document& document, const std::string& name, const AnimationSampler& sampler,
                     const Property& property, std::uint64_t values_a_key) {
  const std::string what(property.name), subject = name + ": value " + label("accessor", sampler.output);
  const auto found = accessor_of(document, name + ": value", sampler.output, property.elements,
                                 "has a type that " + what + " cannot have");
  if (!found) return tl::unexpected(found.error());
  const std::size_t parts = what == kVisiblePath ? 1 : parts_of(sampler);
  const std::uint64_t wanted = at(document.accessors, sampler.input).count * parts * values_a_key;
  if ((*found)->count != wanted)
    return malformed(subject + " has " + std::to_string((*found)->count) + " elements, should have " +
                     std::to_string(wanted));
  const auto values = read_vectors<4>(document, static_cast<std::uint32_t>(sampler.output));
  for (std::size_t i = parts / 2; i < values.size(); i += parts)  // without tangents
    if (property.may_be && !property.may_be(values[i]))
      return malformed(subject + ": element " + std::to_string(i) + " is a value that " + what +
                       " cannot have");
  return {};
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

/// Checks that the target of a channel is there and has the property; `property` may be null.
Checked check_target(const Document& document, const std::string& name, const AnimationChannel& channel,
                     const Property* property) {
  const int index = channel.target_node;
  const std::string& path = channel.target_path;
  if (moves_light(channel)) {
    if (!points_into(document.lights, index))
      return malformed(name + ": there is no " + label("light", index));
    const Light& light = at(document.lights, index);
    if (!path.starts_with("spot/") || light.type == "spot") return {};
    return malformed(name + ": " + label("light", index, light.name) +
                     " is no spot light, so it has no cone");
  }
  if (!points_into(document.nodes, index)) return malformed(name + ": there is no " + label("node", index));
  if (!property) return malformed(name + ": unknown path '" + printable(path) + "'");
  const Node& node = at(document.nodes, index);
  if (node.matrix.empty() || path == "weights" || path == kVisiblePath) return {};
  return malformed(name + ": " + label("node", index, node.name) + " has a matrix and cannot be animated");
}

Checked check_channel(const Document& document, const std::string& name, const Animation& animation,
                      const AnimationChannel& channel) {
  const Property* const property = property_of(moves_light(channel) ? kLights : kNodes, channel.target_path);
  return check_target(document, name, channel, property)
      .and_then([&] { return check_sampler(document, name, animation, channel.sampler); })
      .and_then([&]() -> Checked {
        const AnimationSampler& sampler = at(animation.samplers, channel.sampler);
        if (channel.target_path != "weights") return check_output(document, name, sampler, *property, 1);
        const int mesh = at(document.nodes, channel.target_node).mesh;
        const std::size_t targets = mesh < 0 ? 0 : targets_of(at(document.meshes, mesh));
        if (targets > 0) return check_output(document, name, sampler, *property, targets);
        return accessor_at(document, name + ": value", sampler.output)  // nothing of it is read
            .map([](const Accessor*) {});
      });
}

/// The elements that a channel reads.
std::uint64_t elements_read(const Document& document, const Animation& animation, int sampler) {
  if (!points_into(animation.samplers, sampler)) return 0;
  std::uint64_t sum = 0;
  for (const int accessor : {at(animation.samplers, sampler).input, at(animation.samplers, sampler).output})
    if (points_into(document.accessors, accessor)) sum += at(document.accessors, accessor).count;
  return sum;
}

/// Removes the channels that have faults. `left`: the elements that all channels together may still read.
Checked keep_channels(Document& document, const std::string& name, Animation& animation, Budget& left) {
  std::set<std::tuple<bool, int, std::string>> targets;
  std::vector<AnimationChannel> kept;
  for (std::size_t c = 0; c < animation.channels.size(); ++c) {
    const AnimationChannel& channel = animation.channels[c];
    const std::string of = name + (moves_light(channel) ? ", light " : ", ") + label("channel", c);
    const Checked taken = left.take(elements_read(document, animation, channel.sampler),
                                    of + ": more keys than a file of this size should have");
    if (!taken) return taken;
    Checked checked = check_channel(document, of, animation, channel);
    if (checked && !targets.emplace(moves_light(channel), channel.target_node, channel.target_path).second)
      checked = malformed(of + ": an earlier channel moves the same property");
    if (checked)
      kept.push_back(channel);
    else
      document.repairs.add("it stands still", checked.error());
  }
  animation.channels = std::move(kept);
  return {};
}

}  // namespace

void resolve_pointers(Document& document) {
  std::optional<std::string> still;  // the first pointer to what stands still
  for (Animation& animation : document.animations)
    std::erase_if(animation.channels, [&](AnimationChannel& channel) {
      const std::string pointer =
          text_member(extension(channel.target_extensions, "KHR_animation_pointer"), "pointer");
      const bool is_pointer = channel.target_path == "pointer";
      if (is_pointer && resolve(pointer, kLights, channel)) return false;
      channel.target_extensions.clear();
      if (!is_pointer) return channel.target_node < 0;
      if (resolve(pointer, kNodes, channel)) return false;
      if (!still) still = pointer;
      return true;
    });
  if (still)
    document.warnings.push_back("KHR_animation_pointer: only nodes and lights are animated, so '" +
                                printable(*still) + "' and the like stand still");
}

Checked validate_animations(Document& document) {
  Budget left(element_budget(document));
  return check_each(document.animations, [&](std::size_t a, Animation& animation) {
    return keep_channels(document, label("animation", a, animation.name), animation, left);
  });
}

}  // namespace farshade::gltf
