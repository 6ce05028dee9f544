#include "stereo/scene/gltf_choice.h"

#include "stereo/scene/gltf_validate.h"

namespace farshade::gltf {
namespace {

constexpr std::string_view kPrefix = "camera:";
constexpr std::size_t kMostListed = 12;

/// "'day', 'night'"; "none" for an empty list.
std::string listed(const std::vector<std::string>& names) {
  if (names.empty()) return "none";
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMostListed); ++i)
    text += (i ? ", '" : "'") + printable(names[i]) + "'";
  return names.size() > kMostListed ? text + " and more" : text;
}

std::string scenes_in_words(const Document& document) {
  std::string text;
  for (std::size_t i = 0; i < std::min(document.scenes.size(), kMostListed); ++i)
    text += (i ? ", " : "") + label("", i, document.scene_names[i]).substr(1);
  return document.scenes.size() > kMostListed ? text + " and more" : text;
}

std::string camera_name(const Document& document, std::uint32_t index) {
  const Node& node = document.nodes[index];
  if (!node.name.empty()) return node.name;
  const std::string name = node.camera ? document.cameras[*node.camera] : "";
  return name.empty() ? label("node", index) : name;
}

bool is_called(const Document& document, std::uint32_t index, const std::string& name) {
  const Node& node = document.nodes[index];
  return camera_name(document, index) == name || node.name == std::string(kPrefix) + name ||
         (node.camera && document.cameras[*node.camera] == name);
}

Checked choose_variant(Document& document, const std::string& name) {
  const auto found = std::ranges::find(document.variants, name);
  if (found == document.variants.end())
    return fail(Fault::Missing,
                "there is no variant '" + printable(name) + "'; the file has " + listed(document.variants));
  const auto variant = static_cast<std::uint32_t>(found - document.variants.begin());
  for (Mesh& mesh : document.meshes)
    for (Primitive& primitive : mesh.primitives)
      if (const auto mapped = primitive.variants.find(variant); mapped != primitive.variants.end())
        primitive.material = mapped->second;
  return {};
}

}  // namespace

Checked choose_scene(Document& document, const SceneChoice& choice) {
  if (choice.scene && *choice.scene >= document.scenes.size())
    return fail(Fault::Missing, "there is no scene " + std::to_string(*choice.scene) + "; the file has " +
                                    (document.scenes.empty() ? "none" : scenes_in_words(document)));
  if (choice.scene) document.default_scene = choice.scene;
  return choice.variant.empty() ? Checked{} : choose_variant(document, choice.variant);
}

std::vector<std::uint32_t> camera_nodes(const Document& document) {
  std::vector<std::uint32_t> found;
  if (document.scenes.empty()) return found;
  for (const std::uint32_t i : parents_first(document, document.scenes[document.default_scene.value_or(0)]))
    if (document.nodes[i].camera || document.nodes[i].name.starts_with(kPrefix)) found.push_back(i);
  return found;
}

Checked choose_camera(Document& document, const SceneChoice& choice) {
  if (choice.camera.empty()) return {};
  std::vector<std::string> names;
  for (const std::uint32_t i : camera_nodes(document)) {
    if (is_called(document, i, choice.camera)) {
      document.chosen_camera = i;
      return {};
    }
    names.push_back(camera_name(document, i));
  }
  return fail(Fault::Missing,
              "there is no camera '" + printable(choice.camera) + "'; the scene has " + listed(names));
}

FileContents contents_of(const Document& document) {
  FileContents offer{document.scene_names, {}, document.variants, document.default_scene.value_or(0)};
  for (const std::uint32_t i : camera_nodes(document)) offer.cameras.push_back(camera_name(document, i));
  return offer;
}

}  // namespace farshade::gltf
