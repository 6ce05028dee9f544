#include "stereo/gltf/gltf_extensions.h"

#include <algorithm>
#include <set>
#include <string_view>

#include "stereo/base/printable.h"

namespace farshade::gltf {
namespace {

constexpr std::string_view kKnownExtensions[] = {"EXT_mesh_gpu_instancing", "EXT_meshopt_compression",
                                                 "EXT_texture_webp",        "KHR_draco_mesh_compression",
                                                 "KHR_lights_punctual",     "KHR_materials_variants",
                                                 "KHR_mesh_quantization",   "KHR_meshopt_compression",
                                                 "KHR_node_visibility",     "KHR_texture_transform"};

bool is_known(std::string_view name) {
  return std::ranges::find(kKnownExtensions, name) != std::end(kKnownExtensions);
}

/// Extensions without which the scene is drawn, and what is different then.
struct LookExtension {
  std::string_view name, without;
};
constexpr LookExtension kLookExtensions[] = {
    {"KHR_materials_emissive_strength", "surfaces do not glow"},
    {"KHR_materials_unlit", "materials without light are lit"},
    {"KHR_materials_", "materials have base colours only"},
    {"KHR_texture_basisu", ""},     // gltf_materials.cpp warns
    {"EXT_texture_avif", ""},       // gltf_materials.cpp warns
    {"KHR_animation_pointer", ""},  // gltf_pointers.cpp warns
};

const LookExtension* look_of(std::string_view name) {
  const auto* found = std::ranges::find_if(
      kLookExtensions, [&](const LookExtension& look) { return name.starts_with(look.name); });
  return found == std::end(kLookExtensions) ? nullptr : found;
}

}  // namespace

Expected<void> check_extensions(const std::vector<std::string>& required) {
  for (const std::string& name : required)
    if (!is_known(name) && !look_of(name))
      return fail(Fault::Unsupported, "the required extension '" + printable(name) +
                                          "' is not supported: export the file without it");
  return {};
}

std::vector<std::string> warnings_of_extensions(const std::vector<std::string>& used) {
  std::vector<std::string> warnings;
  for (const std::string& name : std::set<std::string>(used.begin(), used.end())) {
    const LookExtension* const look = is_known(name) ? nullptr : look_of(name);
    if (look && !look->without.empty())
      warnings.push_back(printable(name) + " is not drawn: " + std::string(look->without));
  }
  return warnings;
}

}  // namespace farshade::gltf
