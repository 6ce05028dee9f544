/// tinygltf 2.7 refuses, changes or forgets some of what the loader needs: indices without a buffer view
/// (Draco), buffers without bytes (meshopt), '+' in names of files, media types that it does not know,
/// strides that are no multiple of 4, channels without a node (KHR_animation_pointer). It also forms the
/// address of an image in a buffer before anyone could check it. So it reads a text without buffers and
/// images, which are read here, and what else tinygltf would refuse is put back afterwards.
#include "stereo/gltf/gltf_stages.h"

#include <fstream>  // tinygltf's writers need it and do not include it with TINYGLTF_NO_FS

#define TINYGLTF_IMPLEMENTATION
#include <tiny_gltf.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "stereo/gltf/gltf_extensions.h"

namespace farshade::gltf {
namespace {

using nlohmann::json;

Expected<json> json_from(std::string_view text) try {
  json root = json::parse(text);
  if (!root.is_object()) return malformed("JSON: the file is not an object");
  return root;
} catch (const json::exception& refusal) {
  const std::string_view what = refusal.what();
  const auto after_tag = what.find("] ");
  return malformed("JSON: " + printable(after_tag == what.npos ? what : what.substr(after_tag + 2)));
}

/// glTF 1.0 has numbers as versions, or none, and objects instead of lists. Some files of 2.0 have numbers,
/// too.
bool is_version_1(const json& root) {
  const auto asset = root.find("asset"), meshes = root.find("meshes");
  if (asset != root.end() && asset->is_object() && asset->contains("version") &&
      (*asset)["version"].is_number() && (*asset)["version"] < 2)
    return true;
  return meshes != root.end() && meshes->is_object();
}

Checked check_version(json& root, Repairs& repairs) {
  json& asset = root["asset"];
  if (asset.emplace("version", "2.0").second)
    repairs.add("the file is read as glTF 2.0", "asset.version is missing");
  const std::string version = asset["version"], least = asset.value("minVersion", "2.0");
  const bool is_enough = least == "2.0" || least.starts_with("1.");
  if ((version == "2" || version.starts_with("2.")) && is_enough) return {};
  return fail(Fault::Unsupported,
              "glTF version " + printable(is_enough ? version : least) + ", only 2.0 is read");
}

/// The objects of a list; none if it is absent.
std::span<json> list_of(json& of, const char* name) {
  const auto found = of.find(name);
  return found == of.end() ? std::span<json>() : std::span<json>(found->get_ref<json::array_t&>());
}

/// The bytes of what tinygltf makes of an object in the list `name`.
std::uint64_t object_bytes(std::string_view name) {
  constexpr std::pair<std::string_view, std::size_t> kLarge[] = {
      {"materials", sizeof(Material)}, {"cameras", sizeof(tinygltf::Camera)},
      {"lights", sizeof(Light)},       {"images", sizeof(tinygltf::Image)},
      {"nodes", sizeof(Node)},         {"accessors", sizeof(Accessor)}};
  const auto* found = std::ranges::find(kLarge, name, [](const auto& large) { return large.first; });
  return found == std::end(kLarge) ? sizeof(AnimationChannel) : found->second;
}

/// The bytes of what tinygltf makes of all objects in lists.
std::uint64_t model_bytes(const json& value) {
  std::uint64_t sum = 0;
  if (value.is_array())
    for (const json& element : value) sum += model_bytes(element);
  if (value.is_object())
    for (const auto& [name, member] : value.items()) {
      if (member.is_array() && !member.empty() && member.front().is_object())
        sum += member.size() * object_bytes(name);
      sum += model_bytes(member);
    }
  return sum;
}

/// "materials":[{},{},...] would make 700 bytes of each byte.
Checked check_size(const json& root, std::size_t text_bytes) {
  constexpr std::uint64_t kAlways = std::uint64_t{1} << 26, kOfEachByte = 64;
  if (model_bytes(root) <= kAlways + kOfEachByte * text_bytes) return {};
  return fail(Fault::OutOfRange, "more objects than a file of this size should have");
}

/// The extension that compresses buffers, and its newer name.
bool is_fallback(const json& buffer) {
  for (const char* name : {"/extensions/KHR_meshopt_compression", "/extensions/EXT_meshopt_compression"})
    if (const json::json_pointer at(name); buffer.contains(at)) return buffer[at].value("fallback", false);
  return false;
}

/// Mends what tinygltf changes or does not keep.
void mend_before_reading(json& root, Repairs& repairs) {
  for (std::size_t i = 0; json & node : list_of(root, "nodes")) {
    const std::string name = label("node", i++, node.value("name", ""));
    if (!node.contains("matrix")) continue;
    if (node.erase("translation") + node.erase("rotation") + node.erase("scale") > 0)
      repairs.add("the matrix counts", name + " has both a matrix and translation, rotation or scale");
  }
  const json::json_pointer lights("/extensions/KHR_lights_punctual");
  if (!root.contains(lights)) return;
  for (std::size_t i = 0; json & light : list_of(root[lights], "lights")) {
    const std::string name = label("light", i++, light.value("name", ""));
    if (light["type"] != "spot" || light.contains("spot")) continue;
    repairs.add("it has the default cone", name + " is a spot without a cone");
    light["spot"] = json::object();
  }
}

/// Only the first buffer of a GLB may be its binary chunk; every other buffer needs a URI.
Expected<Bytes> bytes_of_buffer(const json& buffer, std::span<const std::byte> bin, SceneFolder& folder) {
  if (buffer.contains("uri")) return folder.load(buffer["uri"]);
  if (bin.empty()) return malformed("it has neither a URI nor a GLB's binary chunk");
  const auto* first = reinterpret_cast<const std::uint8_t*>(bin.data());
  return Bytes(first, first + std::min<std::uint64_t>(bin.size(), buffer["byteLength"]));
}

/// Reads the buffers. What one does not have is missed by those who read it.
Checked add_buffers(const json& buffers, std::span<const std::byte> bin, SceneFolder& folder,
                    Document& document) {
  for (const json& from : buffers) {
    tinygltf::Buffer& to = document.buffers.emplace_back();
    to.name = from.value("name", "");
    if (!to.name.empty() || is_fallback(from)) continue;
    const std::string name = label("buffer", document.buffers.size() - 1);
    auto data =
        bytes_of_buffer(from, document.buffers.size() == 1 ? bin : std::span<const std::byte>(), folder);
    if (!data && data.error().fault == Fault::Mismatch) return tl::unexpected(data.error());
    if (!data) {
      to.name = name + ": " + data.error().what;
      continue;
    }
    const std::uint64_t bytes = from["byteLength"];
    if (data->size() < bytes)
      to.name = name + ": its data has " + std::to_string(data->size()) + " bytes, byteLength is " +
                std::to_string(bytes);
    to.data = std::move(*data);
    to.data.resize(std::min<std::uint64_t>(to.data.size(), bytes));
  }
  return {};
}

/// Reads the files of images. An image in a buffer view has no bytes of its own.
Checked add_images(const json& images, SceneFolder& folder, Document& document) {
  for (const json& from : images) {
    tinygltf::Image& to = document.images.emplace_back();
    to.name = from.value("name", "");
    to.bufferView = from.value("bufferView", -1);
    const bool has_file = from.contains("uri"), has_view = to.bufferView >= 0;
    if (has_file && has_view)
      document.repairs.add("the buffer view is drawn", label("image", document.images.size() - 1, to.name) +
                                                           " has both a URI and a buffer view");
    Expected<Bytes> file = has_view   ? Bytes{}
                           : has_file ? folder.load(from["uri"])
                                      : Expected<Bytes>(malformed("it has neither a URI nor a buffer view"));
    if (!file && file.error().fault == Fault::Mismatch) return tl::unexpected(file.error());
    document.unreadable.push_back(file ? std::nullopt : std::optional(file.error()));
    if (file) to.image = std::move(*file);
  }
  return {};
}

/// Moves a number to the extras, of which keep_members leaves none. As a fraction it keeps its 53 bits.
void hide(json& object, const char* name, double otherwise) {
  object["extras"] = object.value(name, otherwise);
  object.erase(name);
}

/// tinygltf refuses indices whose accessor has no buffer view, and strides that are no multiple of 4.
void hide_what_is_refused(json& root, Repairs& repairs) {
  for (json& mesh : list_of(root, "meshes"))
    for (json& primitive : mesh["primitives"]) hide(primitive, "indices", -1);
  for (std::size_t i = 0; json & view : list_of(root, "bufferViews")) {
    const std::string name = label("buffer view", i++);
    const std::uint64_t stride = view.value("byteStride", std::uint64_t{4});
    if (stride < 4 || stride > 252 || stride % 4 != 0)
      repairs.add(kReadAnyway, name + ": its stride should be a multiple of 4 from 4 to 252");
    hide(view, "byteStride", 0);
  }
}

void put_back(Document& document) {
  for (Mesh& mesh : document.meshes)
    for (Primitive& primitive : mesh.primitives) primitive.indices = primitive.extras.GetNumberAsInt();
  for (BufferView& view : document.bufferViews)
    view.byteStride = static_cast<std::size_t>(view.extras.GetNumberAsDouble());
}

/// tinygltf 2.7 leaves out channels without a node, and empty objects in lists of extensions (variants
/// without a name). It refuses cameras of which it does not know all numbers; the loader reads only their
/// names.
void add_what_is_required(json& root) {
  for (json& animation : list_of(root, "animations"))
    for (json& channel : animation["channels"])
      if (json& target = channel["target"]; target["path"] == "pointer") target["node"] = 0;
  if (const json::json_pointer at("/extensions/KHR_materials_variants"); root.contains(at))
    for (json& variant : list_of(root[at], "variants")) variant.emplace("name", "");
  for (json& camera : list_of(root, "cameras")) {
    camera["type"] = "perspective";
    camera["perspective"] = {{"yfov", 1}, {"znear", 1}};
  }
}

/// Reads the members of the table, without files.
Expected<Document> document_from(json root, Repairs repairs) {
  hide_what_is_refused(root, repairs);
  add_what_is_required(root);
  const std::string text = root.dump();
  root = nullptr;  // tinygltf parses a copy
  if (text.size() > std::numeric_limits<unsigned int>::max())
    return fail(Fault::OutOfRange, "the JSON has more text than can be read");
  Document document;
  std::string error, warning;
  if (!tinygltf::TinyGLTF().LoadASCIIFromString(&document, &error, &warning, text.data(),
                                                static_cast<unsigned int>(text.size()), ""))
    // No file is known of which the checks before leave this to tinygltf.
    return malformed("tinygltf: " +
                     (error.empty() ? "it cannot be read" : printable(error.substr(0, error.find('\n')))));
  put_back(document);
  document.repairs = std::move(repairs);
  return document;
}

}  // namespace

Expected<Document> read_document(const Container& container, SceneFolder& folder) {
  Expected<json> root = json_from(container.json);
  if (!root) return tl::unexpected(root.error());
  if (is_version_1(*root)) return fail(Fault::Unsupported, "glTF version 1.0, only 2.0 is read");
  Repairs repairs = container.repairs;
  const Checked supported = check_extensions(*root);
  std::vector<std::string> warnings = look_warnings(*root);
  keep_members(*root, repairs);
  const Checked checked = check_version(*root, repairs).and_then([&] { return supported; }).and_then([&] {
    return check_size(*root, container.json.size());
  });
  if (!checked) return tl::unexpected(checked.error());
  mend_before_reading(*root, repairs);
  const json buffers = std::move((*root)["buffers"]), images = std::move((*root)["images"]);
  root->erase("buffers");
  root->erase("images");
  Expected<Document> document = document_from(std::move(*root), std::move(repairs));
  if (!document) return document;
  const Checked files = add_buffers(buffers, container.bin, folder, *document).and_then([&] {
    return add_images(images, folder, *document);
  });
  if (!files) return tl::unexpected(files.error());
  document->warnings = std::move(warnings);
  resolve_pointers(*document);
  return document;
}

}  // namespace farshade::gltf
