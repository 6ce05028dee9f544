#include "stereo/gltf/gltf_extensions.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "stereo/gltf/gltf_model.h"

namespace farshade::gltf {
namespace {

using Json = nlohmann::json;

/// Extensions of which the same is missing in the picture.
struct Extensions {
  std::initializer_list<std::string_view> names;  ///< one that ends in '_' stands for all that begin with it
  std::string_view without{};  ///< how the picture differs; empty: it does not, or others warn
  bool may_be_required = true;
};
constexpr std::string_view kColorsOnly = "materials have base colours only", kUnknown = "unknown";
const Extensions kExtensions[] = {
    // obeyed
    {{"EXT_mesh_gpu_instancing", "EXT_meshopt_compression", "EXT_texture_webp", "KHR_draco_mesh_compression",
      "KHR_lights_punctual", "KHR_materials_variants", "KHR_mesh_quantization", "KHR_meshopt_compression",
      "KHR_node_visibility", "KHR_texture_transform"}},
    // resolve_pointers, gltf_materials.cpp and kLooks warn
    {{"KHR_animation_pointer", "EXT_texture_avif", "KHR_texture_basisu", "KHR_materials_emissive_strength",
      "KHR_materials_transmission"}},
    // nothing that can be seen
    {{"AGI_stk_metadata", "EXT_instance_features", "EXT_mesh_features", "EXT_mesh_manifold",
      "EXT_structural_metadata", "FB_geometry_metadata", "GODOT_single_root", "KHR_audio_emitter",
      "KHR_implicit_shapes", "KHR_node_hoverability", "KHR_node_selectability", "KHR_xmp", "KHR_xmp_json_ld",
      "MSFT_audio_emitter"}},
    // looks
    {{"KHR_materials_unlit"}, "materials without light are lit"},
    {{"KHR_materials_"}, kColorsOnly},
    {{"ADOBE_materials_clearcoat_specular", "ADOBE_materials_clearcoat_tint",
      "ADOBE_materials_thin_transparency", "EXT_materials_bump", "MSFT_packing_normalRoughnessMetallic",
      "MSFT_packing_occlusionRoughnessMetallic"},
     kColorsOnly,
     false},
    {{"EXT_texture_astc", "EXT_texture_procedurals", "EXT_texture_video", "KHR_texture_procedurals",
      "MPEG_texture_video", "MSFT_texture_dds"},
     "textures have the file's PNG or JPEG, or none",
     false},
    {{"KHR_techniques_webgl", "NV_materials_mdl"}, "materials have the file's base colours", false},
    {{"EXT_lights_ies"}, "lights shine as without a profile", false},
    {{"EXT_lights_image_based", "KHR_environment_map", "KHR_lights"},
     "only the lights of KHR_lights_punctual shine",
     false},
    {{"MSFT_lod"}, "nodes have their finest level", false},
    // shapes
    {{"CESIUM_primitive_outline"}, "outlines are missing", false},
    {{"CESIUM_RTC"}, "the scene stands at the origin", false},
    {{"EXT_mesh_primitive_edge_visibility"}, "edges are missing", false},
    {{"EXT_mesh_primitive_restart", "KHR_mesh_primitive_restart"}, "strips and fans are not cut", false},
    {{"EXT_primitive_voxels"}, "voxels are missing", false},
    {{"KHR_accessor_float64"}, "numbers of 64 bits are not read", false},
    {{"KHR_gaussian_splatting"}, "splats are missing", false},
    // motion
    {{"AGI_articulations"}, "articulations stand still", false},
    {{"KHR_interactivity"}, "nothing reacts", false},
    {{"KHR_physics_rigid_bodies", "MSFT_physics"}, "bodies do not fall", false},
};

/// The row of an extension; null if there is none.
const Extensions* known(std::string_view name) {
  const auto* found = std::ranges::find_if(kExtensions, [&](const Extensions& row) {
    return std::ranges::any_of(row.names, [&](std::string_view one) {
      return one.ends_with('_') ? name.starts_with(one) : name == one;
    });
  });
  return found == std::end(kExtensions) ? nullptr : found;
}

/// Member `name` of a value of any type; null if it is not there.
const Json& part(const Json& of, const char* name) {
  static const Json none;
  const auto found = of.is_object() ? of.find(name) : of.end();
  return found == of.end() ? none : *found;
}
/// The texts of a list.
std::set<std::string> names_in(const Json& list) {
  std::set<std::string> names;
  if (list.is_array())
    for (const Json& name : list)
      if (name.is_string()) names.insert(name.get<std::string>());
  return names;
}
bool is_above_0(const Json& number) {
  return number.is_number() && number.get<double>() > 0;
}
template <class Is>
bool any_of(const Json& list, Is is) {
  return list.is_array() && std::any_of(list.begin(), list.end(), is);
}

bool has_maps(const Json& material) {
  const Json &surface = part(material, "pbrMetallicRoughness"), &rough = part(surface, "roughnessFactor");
  return material.contains("normalTexture") || material.contains("occlusionTexture") ||
         surface.contains("metallicRoughnessTexture") || is_above_0(part(surface, "metallicFactor")) ||
         (rough.is_number() && rough < 1);
}
bool glows(const Json& material) {
  return any_of(part(material, "emissiveFactor"), is_above_0);
}
bool blends(const Json& material) {
  const Json &surface = part(material, "pbrMetallicRoughness"), &color = part(surface, "baseColorFactor");
  const bool is_clear = color.is_array() && color.size() == 4 && color[3] != 1;
  return part(material, "alphaMode") == "BLEND" && (is_clear || surface.contains("baseColorTexture"));
}
bool transmits(const Json& material) {
  return is_above_0(
      part(part(part(material, "extensions"), "KHR_materials_transmission"), "transmissionFactor"));
}
bool has_lines(const Json& mesh) {
  return any_of(part(mesh, "primitives"), [](const Json& primitive) {
    const Json& mode = part(primitive, "mode");
    return mode.is_number_unsigned() && mode.get<std::uint64_t>() < TINYGLTF_MODE_TRIANGLES;
  });
}
bool morphs_looks(const Json& mesh) {
  return any_of(part(mesh, "primitives"), [](const Json& primitive) {
    return any_of(part(primitive, "targets"), [](const Json& target) {
      return target.contains("COLOR_0") || target.contains("TEXCOORD_0") || target.contains("TEXCOORD_1");
    });
  });
}
bool has_many_joints(const Json& mesh) {
  return any_of(part(mesh, "primitives"),
                [](const Json& primitive) { return part(primitive, "attributes").contains("JOINTS_1"); });
}
bool is_nearest(const Json& sampler) {
  return part(sampler, "magFilter") == TINYGLTF_TEXTURE_FILTER_NEAREST;
}

/// What objects of the core specification ask for and is drawn in another way.
struct Look {
  const char *list, *kind;
  bool (*has)(const Json&);
  const char* words;
};
constexpr Look kLooks[] = {
    {"materials", "material", has_maps,
     "shines or has a metal, roughness, normal or occlusion map: materials have base colours only"},
    {"materials", "material", glows, "emits light: surfaces do not glow"},
    {"materials", "material", blends,
     "has alphaMode BLEND: it is a hole where its alpha is below 0.5, and opaque elsewhere"},
    {"materials", "material", transmits,
     "lets light through (KHR_materials_transmission): with a factor above 0.5 it is a hole, else opaque"},
    {"meshes", "mesh", has_lines, "has points or lines: only triangles are drawn"},
    {"meshes", "mesh", morphs_looks,
     "has morph targets of colours or texture coordinates: only shapes are morphed"},
    {"meshes", "mesh", has_many_joints, "has JOINTS_1: vertices follow their first four joints only"},
    {"samplers", "sampler", is_nearest, "has the filter NEAREST: all textures are smoothed"},
};

/// A sentence about the first object that has the look, and the number of others.
void warn(const Json& root, const Look& look, std::vector<std::string>& warnings) {
  const Json& list = part(root, look.list);
  std::string first;
  std::size_t count = 0;
  for (std::size_t i = 0; list.is_array() && i < list.size(); ++i)
    if (list[i].is_object() && look.has(list[i]) && ++count == 1) {
      const Json& name = part(list[i], "name");
      first = label(look.kind, i, name.is_string() ? name.get<std::string>() : "");
    }
  if (count == 0) return;
  const std::string others = count > 1 ? " (and " + std::to_string(count - 1) + " more)" : "";
  warnings.push_back(first + others + " " + look.words);
}

}  // namespace

std::vector<std::string_view> known_extensions() {
  std::vector<std::string_view> names;
  for (const Extensions& row : kExtensions) names.insert(names.end(), row.names);
  return names;
}

Expected<void> check_extensions(const Json& root) {
  for (const std::string& name : names_in(part(root, "extensionsRequired")))
    if (const Extensions* const of = known(name); !of || !of->may_be_required)
      return fail(Fault::Unsupported, "the required extension '" + printable(name) +
                                          "' is not supported: export the file without it");
  return {};
}

std::vector<std::string> look_warnings(const Json& root) {
  std::map<std::string_view, std::string> names;  // of the extensions, by what is different
  std::set<std::string> used = names_in(part(root, "extensionsUsed"));
  used.merge(names_in(part(root, "extensionsRequired")));
  for (const std::string& name : used) {
    const Extensions* const of = known(name);
    const std::string_view without = of ? of->without : kUnknown;
    if (without.empty()) continue;
    std::string& text = names[without];
    text += (text.empty() ? "" : ", ") + printable(name);
  }
  std::vector<std::string> warnings;
  for (const auto& [without, text] : names)
    warnings.push_back(text + (text.find(',') == text.npos ? " is" : " are") +
                       " not drawn: " + std::string(without));
  for (const Look& look : kLooks) warn(root, look, warnings);
  return warnings;
}

}  // namespace farshade::gltf
