/// tinygltf 2.7 refuses, changes or forgets some of what the loader needs: indices without a buffer view
/// (Draco), buffers without bytes (meshopt), '+' in names of files, media types that it does not know,
/// channels without a node (KHR_animation_pointer). It also forms the address of an image in a buffer before
/// anyone could check it. So it reads a text that stands for the file: buffers and images have numbers for
/// names, under which SceneFolder serves their bytes (FileServer), and what tinygltf would refuse is put back
/// afterwards.
#include "stereo/gltf/gltf_read.h"

#include <fstream>  // tinygltf's writers need it and do not include it with TINYGLTF_NO_FS

#define TINYGLTF_IMPLEMENTATION
#include <tiny_gltf.h>

#include <charconv>
#include <limits>
#include <nlohmann/json.hpp>

#include "stereo/gltf/gltf_extensions.h"
#include "stereo/gltf/gltf_members.h"
#include "stereo/gltf/gltf_pointers.h"

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

/// glTF 1.0 has numbers as versions, or none, and objects instead of lists.
bool is_version_1(const json& root) {
  const auto asset = root.find("asset"), meshes = root.find("meshes");
  if (asset != root.end() && asset->is_object() && asset->contains("version") &&
      (*asset)["version"].is_number())
    return true;
  return meshes != root.end() && meshes->is_object();
}

Checked check_version(const json& asset) {
  const std::string version = asset["version"], least = asset.value("minVersion", "2.0");
  if (version.starts_with("2.") && least == "2.0") return {};
  return fail(Fault::Unsupported,
              "glTF version " + printable(least == "2.0" ? version : least) + ", only 2.0 is read");
}

/// The objects of a list; none if it is absent.
std::span<json> list_of(json& of, const char* name) {
  const auto found = of.find(name);
  return found == of.end() ? std::span<json>() : std::span<json>(found->get_ref<json::array_t&>());
}

/// Takes a list away.
json::array_t taken(json& of, const char* name) {
  const auto found = of.find(name);
  return found == of.end() ? json::array_t{} : std::move(found->get_ref<json::array_t&>());
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

/// Calls `check_item(index, item)` for each object of a list, up to the first fault.
template <class Check>
Checked check_list(json& of, const char* name, Check check_item) {
  const std::span<json> list = list_of(of, name);
  for (std::size_t i = 0; i < list.size(); ++i)
    if (Checked checked = check_item(i, list[i]); !checked) return checked;
  return {};
}

Checked check_view(std::size_t index, const json& view) {
  const auto stride = view.value("byteStride", std::uint64_t{4});
  if (stride >= 4 && stride <= 252 && stride % 4 == 0) return {};
  return malformed(label("buffer view", index) + ": its stride should be a multiple of 4 from 4 to 252");
}

Checked check_accessor(std::size_t index, const json& accessor) {
  constexpr std::string_view kTypes[] = {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"};
  const auto& type = accessor["type"].get_ref<const std::string&>();
  const auto component = accessor["componentType"].get<int>();
  if (bytes_of(static_cast<Component>(component)) == 0)
    return malformed(label("accessor", index) + ": unknown component type " + std::to_string(component));
  if (std::ranges::find(kTypes, type) != std::end(kTypes)) return {};
  return malformed(label("accessor", index) + ": unknown type '" + printable(type) + "'");
}

Checked check_image(std::size_t index, const json& image) {
  if (image.contains("bufferView") != image.contains("uri")) return {};
  return malformed(label("image", index) + " should have either a URI or a buffer view");
}

Checked check_node(std::size_t index, const json& node) {
  const bool has_parts = node.contains("translation") || node.contains("rotation") || node.contains("scale");
  if (!node.contains("matrix") || !has_parts) return {};
  return malformed(label("node", index, node.value("name", "")) +
                   " has both a matrix and translation, rotation or scale");
}

Checked check_light(std::size_t index, const json& light) {
  if (light["type"] != "spot" || light.contains("spot")) return {};
  return malformed(label("light", index, light.value("name", "")) + " is a spot without a cone");
}

/// Checks what tinygltf changes or does not keep.
Checked check_before_reading(json& root) {
  const json::json_pointer lights("/extensions/KHR_lights_punctual");
  return check_list(root, "bufferViews", check_view)
      .and_then([&] { return check_list(root, "accessors", check_accessor); })
      .and_then([&] { return check_list(root, "images", check_image); })
      .and_then([&] { return check_list(root, "nodes", check_node); })
      .and_then([&] {
        return root.contains(lights) ? check_list(root[lights], "lights", check_light) : Checked{};
      });
}

/// Serves the file callbacks of tinygltf, which asks for buffer 3 as "b3" and for image 5 as "i5".
class FileServer {
 public:
  /// Takes the descriptions of buffers and images from `root`, and puts stand-ins in their place.
  FileServer(json& root, std::span<const std::byte> bin, SceneFolder& folder)
      : buffers_(taken(root, "buffers")),
        images_(taken(root, "images")),
        bin_(bin),
        folder_(folder),
        unreadable_(images_.size()) {
    json::array_t buffers, images;
    for (const json& buffer : buffers_)
      buffers.push_back({{"uri", "b" + std::to_string(buffers.size())},
                         {"byteLength", is_fallback(buffer) ? json(1) : buffer["byteLength"]}});
    for (const json& image : images_)
      images.push_back({{"uri", "i" + std::to_string(images.size())}, {"name", image.value("name", "")}});
    root["buffers"] = std::move(buffers);
    root["images"] = std::move(images);
  }

  [[nodiscard]] tinygltf::FsCallbacks callbacks() { return callbacks_for<>(this); }

  /// The first buffer or data URI that could not be read.
  [[nodiscard]] const Checked& verdict() const { return verdict_; }

  /// Puts back what the stand-ins did not say.
  void complete(Document& document) {
    for (std::size_t i = 0; i < buffers_.size(); ++i)
      if (is_fallback(buffers_[i])) document.buffers[i].data.clear();
    for (std::size_t i = 0; i < images_.size(); ++i)
      document.images[i].bufferView = images_[i].value("bufferView", -1);
    document.unreadable = std::move(unreadable_);
  }

 private:
  /// GetFileSizeInBytes is new in tinygltf 2.9, and compares the size with a limit of its own. SceneFolder
  /// has limits.
  template <class Callbacks = tinygltf::FsCallbacks>
  static Callbacks callbacks_for(FileServer* server) {
    Callbacks callbacks{};
    callbacks.FileExists = [](const std::string&, void*) { return true; };
    callbacks.ExpandFilePath = [](const std::string& name, void*) { return name; };
    callbacks.ReadWholeFile = [](Bytes* out, std::string*, const std::string& name, void* user) {
      return static_cast<FileServer*>(user)->read(name, *out);
    };
    callbacks.WriteWholeFile = [](std::string*, const std::string&, const Bytes&, void*) { return false; };
    if constexpr (requires { callbacks.GetFileSizeInBytes; })
      callbacks.GetFileSizeInBytes = [](std::size_t*, std::string*, const std::string&, void*) {
        return true;
      };
    callbacks.user_data = server;
    return callbacks;
  }

  bool read(std::string_view name, Bytes& out) {
    std::size_t index = 0;
    std::from_chars(name.data() + 1, name.data() + name.size(), index);
    Expected<Bytes> bytes = name.starts_with('b') ? buffer(index) : image(index);
    if (!bytes) return false;
    out = std::move(*bytes);
    return true;
  }

  Expected<Bytes> refused(Error error) {
    if (verdict_) verdict_ = tl::unexpected(error);
    return tl::unexpected(std::move(error));
  }

  /// Only the first buffer of a GLB may be its binary chunk; every other buffer needs a URI.
  Expected<Bytes> buffer(std::size_t index) {
    const json& from = buffers_[index];
    const std::string name = label("buffer", index);
    const std::uint64_t bytes = from["byteLength"];
    if (is_fallback(from)) return Bytes(1);
    if (!from.contains("uri")) {
      if (index > 0 || bin_.empty())
        return refused({Fault::Malformed, name + " has neither a URI nor a GLB's binary chunk"});
      if (bytes > bin_.size())
        return refused({Fault::Malformed, name + ": " + std::to_string(bytes) +
                                              " bytes are more than the binary chunk has (" +
                                              std::to_string(bin_.size()) + ")"});
      const auto* first = reinterpret_cast<const std::uint8_t*>(bin_.data());
      return Bytes(first, first + bytes);
    }
    Expected<Bytes> data = folder_.load(from["uri"]);
    if (!data) return refused({data.error().fault, name + ": " + data.error().what});
    if (data->size() != bytes)
      return refused({Fault::Malformed, name + ": its data has " + std::to_string(data->size()) +
                                            " bytes, byteLength is " + std::to_string(bytes)});
    return data;
  }

  /// An image in a buffer view has no bytes of its own.
  Expected<Bytes> image(std::size_t index) {
    const json& from = images_[index];
    if (!verdict_ || !from.contains("uri")) return fail(Fault::Missing, "");
    const std::string uri = from["uri"];
    Expected<Bytes> file = folder_.load(uri);
    if (file && file->size() > std::numeric_limits<int>::max())
      file = fail(Fault::OutOfRange, "external file '" + printable(uri) + "': 2 GiB or more");
    if (file) return file;
    if (is_data_uri(uri))
      return refused(
          {file.error().fault, label("image", index, from.value("name", "")) + ": " + file.error().what});
    unreadable_[index] = file.error();
    return file;
  }

  json::array_t buffers_, images_;  ///< as the file describes them
  std::span<const std::byte> bin_;
  SceneFolder& folder_;
  std::vector<std::optional<Error>> unreadable_;
  Checked verdict_;
};

/// tinygltf refuses indices whose accessor has no buffer view. Takes the indices from all primitives.
std::vector<int> take_indices(json& root) {
  std::vector<int> indices;
  for (json& mesh : list_of(root, "meshes"))
    for (json& primitive : mesh["primitives"]) {
      indices.push_back(primitive.value("indices", -1));
      primitive.erase("indices");
    }
  return indices;
}

void put_back(const std::vector<int>& indices, Document& document) {
  auto next = indices.begin();
  for (Mesh& mesh : document.meshes)
    for (Primitive& primitive : mesh.primitives) primitive.indices = *next++;
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

/// The file stays as it is; it is decoded within limits after everything was validated.
bool keep_image_file(tinygltf::Image* image, const int, std::string*, std::string*, int, int,
                     const unsigned char* bytes, int size, void*) {
  image->image.assign(bytes, bytes + size);
  return true;
}

/// Reads the members of the table.
Expected<Document> document_from(json root, FileServer& files) {
  const std::vector<int> indices = take_indices(root);
  add_what_is_required(root);
  const std::string text = root.dump();
  root = nullptr;  // tinygltf parses a copy
  if (text.size() > std::numeric_limits<unsigned int>::max())
    return fail(Fault::OutOfRange, "the JSON has more text than can be read");
  tinygltf::TinyGLTF reader;
  reader.SetFsCallbacks(files.callbacks());
  reader.SetImageLoader(keep_image_file, nullptr);
  Document document;
  std::string error, warning;
  const bool is_read = reader.LoadASCIIFromString(&document, &error, &warning, text.data(),
                                                  static_cast<unsigned int>(text.size()), "");
  if (!files.verdict()) return tl::unexpected(files.verdict().error());
  if (!is_read)  // no file is known of which the checks before leave this to tinygltf
    return malformed("tinygltf: " +
                     (error.empty() ? "it cannot be read" : printable(error.substr(0, error.find('\n')))));
  put_back(indices, document);
  files.complete(document);
  return document;
}

}  // namespace

Expected<Document> read_document(std::string_view text, std::span<const std::byte> bin, SceneFolder& folder) {
  Expected<json> root = json_from(text);
  if (!root) return tl::unexpected(root.error());
  if (is_version_1(*root)) return fail(Fault::Unsupported, "glTF version 1.0, only 2.0 is read");
  using Names = std::vector<std::string>;
  const Checked checked =
      check_needs(*root)
          .and_then([&] { return check_version((*root)["asset"]); })
          .and_then([&] { return check_extensions(root->value("extensionsRequired", Names{})); })
          .and_then([&] { return keep_members(*root); })
          .and_then([&] { return check_size(*root, text.size()); })
          .and_then([&] { return check_before_reading(*root); });
  if (!checked) return tl::unexpected(checked.error());
  FileServer files(*root, bin, folder);
  Expected<Document> document = document_from(std::move(*root), files);
  if (!document) return document;
  document->warnings = warnings_of_extensions(document->extensionsUsed);
  resolve_pointers(*document);
  return document;
}

}  // namespace farshade::gltf
