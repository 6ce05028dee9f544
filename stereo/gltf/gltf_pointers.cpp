#include "stereo/gltf/gltf_pointers.h"

#include <charconv>

namespace farshade::gltf {
namespace {

constexpr std::string_view kNodePaths[] = {"translation", "rotation", "scale", "weights", kVisiblePath};
constexpr std::string_view kLightProperties[] = {"color", "intensity", "range", "spot/innerConeAngle",
                                                 "spot/outerConeAngle"};

/// A pointer to one of `properties` of an element of the list `list`, such as "/nodes/3/scale".
struct Pointed {
  std::uint32_t index = 0;
  std::string property;
};
std::optional<Pointed> pointed(std::string_view pointer, std::string_view list,
                               std::span<const std::string_view> properties) {
  if (!pointer.starts_with(list)) return std::nullopt;
  pointer.remove_prefix(list.size());
  const auto slash = pointer.find('/');
  if (slash == pointer.npos) return std::nullopt;
  Pointed result{0, std::string(pointer.substr(slash + 1))};
  const char* const end = pointer.data() + slash;
  const auto read = std::from_chars(pointer.data(), end, result.index);
  if (read.ec != std::errc{} || read.ptr != end ||
      std::ranges::find(properties, result.property) == properties.end())
    return std::nullopt;
  return result;
}

std::string pointer_of(const AnimationChannel& channel) {
  return text_member(extension(channel.target_extensions, "KHR_animation_pointer"), "pointer");
}

}  // namespace

void resolve_pointers(Document& document) {
  std::optional<std::string> still;  // the first pointer to what stands still
  for (Animation& animation : document.animations) {
    auto& lights = document.light_channels.emplace_back();
    std::erase_if(animation.channels, [&](AnimationChannel& channel) {
      if (channel.target_path != "pointer") return channel.target_node < 0;
      const std::string pointer = pointer_of(channel);
      if (const auto node = pointed(pointer, "/nodes/", kNodePaths)) {
        channel.target_node = static_cast<int>(std::min(node->index, kMaxIndex));
        channel.target_path = node->property;
        return false;
      }
      const auto light = pointed(pointer, "/extensions/KHR_lights_punctual/lights/", kLightProperties);
      if (light)
        lights.push_back({static_cast<std::uint32_t>(channel.sampler), light->index, light->property});
      else if (!still)
        still = pointer;
      return true;
    });
  }
  if (still)
    document.warnings.push_back("KHR_animation_pointer: only nodes and lights are animated, so '" +
                                printable(*still) + "' and the like stand still");
}

}  // namespace farshade::gltf
