#include "stereo/gltf/gltf_stages.h"

namespace farshade::gltf {
namespace {

constexpr std::string_view kPrefix = "camera:";
constexpr std::size_t kMostListed = 12;

/// The words for `count` things with commas between them, or for the first of them; "none" without any.
template <class Word>
std::string listed(std::size_t count, Word word) {
  std::string text;
  for (std::size_t i = 0; i < std::min(count, kMostListed); ++i) text += (i ? ", " : "") + word(i);
  return count == 0 ? "none" : count > kMostListed ? text + " and more" : text;
}
std::string listed(const std::vector<std::string>& names) {
  return listed(names.size(), [&](std::size_t i) { return "'" + printable(names[i]) + "'"; });
}

std::string camera_name(const Document& document, std::uint32_t index) {
  const Node& node = document.nodes[index];
  if (!node.name.empty()) return node.name;
  const std::string name = node.camera < 0 ? "" : at(document.cameras, node.camera).name;
  return name.empty() ? label("node", index) : name;
}

/// The nodes of the default scene, parents first, that carry a camera or whose names begin with `camera:`.
std::vector<std::uint32_t> camera_nodes(const Document& document) {
  std::vector<std::uint32_t> found = parents_first(document, roots_of(document));
  std::erase_if(found, [&](std::uint32_t node) {
    return document.nodes[node].camera < 0 && !document.nodes[node].name.starts_with(kPrefix);
  });
  return found;
}

std::vector<std::string> camera_names(const Document& document) {
  std::vector<std::string> names;
  for (const std::uint32_t node : camera_nodes(document)) names.push_back(camera_name(document, node));
  return names;
}

bool is_called(const Document& document, std::uint32_t index, const std::string& name) {
  const Node& node = document.nodes[index];
  return camera_name(document, index) == name || node.name == std::string(kPrefix) + name ||
         (node.camera >= 0 && at(document.cameras, node.camera).name == name);
}

/// The names of KHR_materials_variants.
std::vector<std::string> variants_of(const Document& document) {
  std::vector<std::string> names;
  const auto* variants = extension(document.extensions, "KHR_materials_variants");
  for (const tinygltf::Value& variant : list_member(variants, "variants"))
    names.push_back(text_member(&variant, "name"));
  return names;
}

/// The material that a primitive has in a variant; if two mappings name the variant, that of the last one.
Index material_in(const Primitive& primitive, int variant) {
  Index material;
  const auto* variants = extension(primitive.extensions, "KHR_materials_variants");
  for (const tinygltf::Value& mapping : list_member(variants, "mappings"))
    for (const tinygltf::Value& of : list_member(&mapping, "variants"))
      if (of.GetNumberAsInt() == variant) material = index_member(&mapping, "material");
  return material;
}

Checked choose_variant(Document& document, const std::string& name) {
  const std::vector<std::string> variants = variants_of(document);
  const auto found = std::ranges::find(variants, name);
  if (found == variants.end())
    return fail(Fault::Missing,
                "there is no variant '" + printable(name) + "'; the file has " + listed(variants));
  const auto variant = static_cast<int>(found - variants.begin());
  for (Mesh& mesh : document.meshes)
    for (Primitive& primitive : mesh.primitives)
      if (const Index mapped = material_in(primitive, variant))
        primitive.material = static_cast<int>(*mapped);
  return {};
}

/// The animations of a file are alternatives, so one plays.
Checked choose_animation(Document& document, const std::string& name) {
  std::vector<std::string>& clips = document.clips;
  for (std::size_t i = 0; i < document.animations.size(); ++i)
    clips.push_back(document.animations[i].name.empty() ? label("animation", i)
                                                        : document.animations[i].name);
  const auto found = std::ranges::find(clips, name);
  const bool is_none = found == clips.end() && name == "none";
  if (found == clips.end() && !name.empty() && name != "all" && !is_none)
    return fail(Fault::Missing,
                "there is no animation '" + printable(name) + "'; the file has " + listed(clips));
  if (name.empty() && clips.size() > 1)
    document.warnings.push_back("of " + std::to_string(clips.size()) + " animations, '" +
                                printable(clips[0]) +
                                "' plays (--animation NAME, all or none): " + listed(clips));
  if (clips.empty() || (found == clips.end() && name == "all")) return {};
  const auto playing = found == clips.end() ? 0 : found - clips.begin();
  const auto count = is_none ? 0 : 1;
  auto& animations = document.animations;
  animations.erase(animations.begin() + playing + count, animations.end());
  animations.erase(animations.begin(), animations.begin() + playing);
  return {};
}

}  // namespace

Checked choose_scene(Document& document, const SceneChoice& choice) {
  if (choice.scene && *choice.scene >= document.scenes.size())
    return fail(Fault::Missing, "there is no scene " + std::to_string(*choice.scene) + "; the file has " +
                                    listed(document.scenes.size(), [&](std::size_t i) {
                                      return label("", i, document.scenes[i].name).substr(1);
                                    }));
  if (choice.scene) document.defaultScene = static_cast<int>(*choice.scene);
  return choose_animation(document, choice.animation).and_then([&] {
    return choice.variant.empty() ? Checked{} : choose_variant(document, choice.variant);
  });
}

Checked choose_camera(Document& document, const SceneChoice& choice) {
  const std::vector<std::uint32_t> nodes = camera_nodes(document);
  const bool is_free = choice.camera.empty();
  const auto found = std::ranges::find_if(nodes, [&](std::uint32_t node) {
    return is_free ? document.nodes[node].name.starts_with(kPrefix)
                   : is_called(document, node, choice.camera);
  });
  if (found != nodes.end())
    document.camera = *found;
  else if (!is_free)
    return fail(Fault::Missing, "there is no camera '" + printable(choice.camera) + "'; the scene has " +
                                    listed(camera_names(document)));
  else if (!nodes.empty())
    document.camera = nodes.front();
  return {};
}

FileContents contents_of(const Document& document) {
  FileContents offer{{},
                     camera_names(document),
                     variants_of(document),
                     document.clips,
                     index_of(document.defaultScene).value_or(0)};
  for (const tinygltf::Scene& scene : document.scenes) offer.scenes.push_back(scene.name);
  return offer;
}

}  // namespace farshade::gltf
