#include "stereo/scene/gltf_parse.h"

#include <fstream>  // tinygltf's writers need it and do not include it with TINYGLTF_NO_FS

#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_FS
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

#include <algorithm>
#include <iterator>

#include "stereo/base/check.h"

namespace farshade::gltf {
namespace {

/// What tinygltf's file callbacks are given: the folder, and what it refused.
struct FileAccess {
  SceneFolder* folder = nullptr;
  std::map<std::string, Error> refused;  ///< by decoded URI
};

bool read_whole_file(std::vector<unsigned char>* out, std::string*, const std::string& uri, void* user) {
  auto& access = *static_cast<FileAccess*>(user);
  auto bytes = access.folder->read(uri);
  if (!bytes) {
    access.refused.insert_or_assign(uri, bytes.error());
    return false;
  }
  const auto* first = reinterpret_cast<const unsigned char*>(bytes->data());
  out->assign(first, first + bytes->size());
  return true;
}

/// Every name "exists": whether it does is said by read_whole_file, with its reason.
/// Likewise its size, which tinygltf asks for since 2.9 and only compares with a limit of its own.
template <class Callbacks = tinygltf::FsCallbacks>
Callbacks callbacks_for(FileAccess& access) {
  Callbacks callbacks{};
  callbacks.FileExists = [](const std::string&, void*) { return true; };
  callbacks.ExpandFilePath = [](const std::string& uri, void*) { return uri; };
  callbacks.ReadWholeFile = read_whole_file;
  callbacks.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
    return false;
  };
  if constexpr (requires { callbacks.GetFileSizeInBytes; })
    callbacks.GetFileSizeInBytes = [](std::size_t*, std::string*, const std::string&, void*) { return true; };
  callbacks.user_data = &access;
  return callbacks;
}

/// Keeps the file as it is; it is decoded after everything was validated. An image in a buffer view is found
/// there.
bool keep_image_file(tinygltf::Image* image, const int, std::string*, std::string*, int, int,
                     const unsigned char* bytes, int size, void*) {
  if (image->bufferView < 0) image->image.assign(bytes, bytes + size);
  return true;
}

Index index_from(int i) {
  return i < 0 ? Index{} : Index{static_cast<std::uint32_t>(i)};
}

std::vector<std::uint32_t> indices_from(const std::vector<int>& list) {
  return {list.begin(), list.end()};
}

glm::dvec3 vec3_from(const std::vector<double>& v) {
  check_eq(v.size(), std::size_t{3}, "schema: numbers in a vector");
  return {v[0], v[1], v[2]};
}

template <class To, class From, class Convert>
std::vector<To> each(const std::vector<From>& list, Convert convert) {
  std::vector<To> result;
  result.reserve(list.size());
  std::transform(list.begin(), list.end(), std::back_inserter(result), convert);
  return result;
}

bool any_weight(const std::vector<double>& weights) {
  return std::any_of(weights.begin(), weights.end(), [](double w) { return w != 0.0; });
}

Accessor accessor_from(const tinygltf::Accessor& from) {
  Accessor to;
  to.view = index_from(from.bufferView);
  to.offset = from.byteOffset;
  to.count = from.count;
  to.component = static_cast<Component>(from.componentType);
  to.normalized = from.normalized;
  const bool is_matrix = from.type >= TINYGLTF_TYPE_MAT2 && from.type <= TINYGLTF_TYPE_MAT4;
  const auto components = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(from.type));
  const auto side = from.type == TINYGLTF_TYPE_MAT2 ? 2u : from.type == TINYGLTF_TYPE_MAT3 ? 3u : 4u;
  to.rows = is_matrix ? side : static_cast<std::uint32_t>(components);
  to.columns = is_matrix ? side : 1u;
  if (!from.sparse.isSparse) return to;
  const auto unsigned_of = [](auto value) { return static_cast<std::uint32_t>(value); };
  const auto& indices = from.sparse.indices;
  const auto& values = from.sparse.values;
  to.sparse = Sparse{unsigned_of(from.sparse.count), unsigned_of(indices.bufferView),
                     unsigned_of(values.bufferView), unsigned_of(indices.byteOffset),
                     unsigned_of(values.byteOffset), static_cast<Component>(indices.componentType)};
  return to;
}

Image image_from(tinygltf::Image& from, const FileAccess& access) {
  Image to{from.name, from.uri, index_from(from.bufferView), std::move(from.image), {}};
  const auto refused = access.refused.find(tinygltf::dlib::urldecode(from.uri));
  if (refused != access.refused.end()) to.unreadable = refused->second;
  return to;
}

TextureUse texture_use_from(const tinygltf::TextureInfo& from) {
  TextureUse to;
  to.texture = static_cast<std::uint32_t>(from.index);
  to.texcoord = static_cast<std::uint32_t>(from.texCoord);
  const auto found = from.extensions.find("KHR_texture_transform");
  if (found == from.extensions.end()) return to;
  const tinygltf::Value& transform = found->second;
  const auto pair = [&](const char* name, glm::dvec2 otherwise) {
    if (!transform.Has(name)) return otherwise;
    const auto& value = transform.Get(name);
    return glm::dvec2(value.Get(0).GetNumberAsDouble(), value.Get(1).GetNumberAsDouble());
  };
  to.offset = pair("offset", to.offset);
  to.scale = pair("scale", to.scale);
  if (transform.Has("rotation")) to.rotation_rad = transform.Get("rotation").GetNumberAsDouble();
  if (transform.Has("texCoord"))
    to.texcoord = static_cast<std::uint32_t>(transform.Get("texCoord").GetNumberAsInt());
  return to;
}

Material material_from(const tinygltf::Material& from) {
  const auto& pbr = from.pbrMetallicRoughness;
  check_eq(pbr.baseColorFactor.size(), std::size_t{4}, "schema: numbers in a colour");
  Material to{from.name, from.alphaMode, {}, from.alphaCutoff, from.doubleSided, {}};
  for (int i = 0; i < 4; ++i) to.base_color[i] = pbr.baseColorFactor[static_cast<std::size_t>(i)];
  if (pbr.baseColorTexture.index >= 0) to.texture = texture_use_from(pbr.baseColorTexture);
  return to;
}

Mesh mesh_from(const tinygltf::Mesh& from) {
  Mesh to{from.name, {}, any_weight(from.weights)};
  for (const auto& primitive : from.primitives) {
    std::map<std::string, std::uint32_t> attributes(primitive.attributes.begin(), primitive.attributes.end());
    to.primitives.push_back({std::move(attributes), index_from(primitive.indices),
                             index_from(primitive.material), static_cast<Mode>(primitive.mode)});
  }
  return to;
}

Node node_from(const tinygltf::Node& from) {
  Node to;
  to.name = from.name;
  to.children = indices_from(from.children);
  to.mesh = index_from(from.mesh);
  to.camera = index_from(from.camera);
  to.skin = index_from(from.skin);
  to.morphed = any_weight(from.weights);
  if (const auto found = from.extensions.find("KHR_lights_punctual"); found != from.extensions.end())
    to.light = index_from(found->second.Get("light").GetNumberAsInt());
  if (!from.translation.empty()) to.translation = vec3_from(from.translation);
  if (!from.scale.empty()) to.scale = vec3_from(from.scale);
  if (const auto& r = from.rotation; !r.empty()) to.rotation = glm::dquat(r.at(3), r.at(0), r.at(1), r.at(2));
  if (from.matrix.empty()) return to;
  check_eq(from.matrix.size(), std::size_t{16}, "schema: numbers in a matrix");
  to.matrix.emplace();
  for (int i = 0; i < 16; ++i) (*to.matrix)[i / 4][i % 4] = from.matrix[static_cast<std::size_t>(i)];
  return to;
}

Light light_from(const tinygltf::Light& from) {
  Light to;
  to.name = from.name;
  to.type = from.type;
  if (!from.color.empty()) to.color = vec3_from(from.color);
  to.intensity = from.intensity;
  to.inner_cone_rad = from.spot.innerConeAngle;
  to.outer_cone_rad = from.spot.outerConeAngle;
  if (from.range > 0.0) to.range_m = from.range;
  return to;
}

Animation animation_from(const tinygltf::Animation& from) {
  const auto unsigned_of = [](int value) { return static_cast<std::uint32_t>(value); };
  return {from.name,
          each<AnimationChannel>(
              from.channels,
              [&](const auto& channel) -> AnimationChannel {
                return {unsigned_of(channel.sampler), unsigned_of(channel.target_node), channel.target_path};
              }),
          each<AnimationSampler>(from.samplers, [&](const auto& sampler) -> AnimationSampler {
            return {unsigned_of(sampler.input), unsigned_of(sampler.output), sampler.interpolation};
          })};
}

Document document_from(tinygltf::Model& model, const FileAccess& access) {
  Document document;
  document.required_extensions = std::move(model.extensionsRequired);
  for (auto& buffer : model.buffers) document.buffers.push_back(std::move(buffer.data));
  document.views = each<BufferView>(model.bufferViews, [](const auto& view) -> BufferView {
    return {static_cast<std::uint32_t>(view.buffer), view.byteOffset, view.byteLength, view.byteStride};
  });
  document.accessors = each<Accessor>(model.accessors, accessor_from);
  for (auto& image : model.images) document.images.push_back(image_from(image, access));
  document.texture_samplers = each<TextureSampler>(model.samplers, [](const auto& sampler) -> TextureSampler {
    return {static_cast<std::uint32_t>(sampler.wrapS), static_cast<std::uint32_t>(sampler.wrapT)};
  });
  document.textures = each<Texture>(model.textures, [](const auto& texture) -> Texture {
    return {texture.name, index_from(texture.source), index_from(texture.sampler)};
  });
  document.materials = each<Material>(model.materials, material_from);
  document.meshes = each<Mesh>(model.meshes, mesh_from);
  document.nodes = each<Node>(model.nodes, node_from);
  document.lights = each<Light>(model.lights, light_from);
  document.animations = each<Animation>(model.animations, animation_from);
  document.scenes = each<std::vector<std::uint32_t>>(
      model.scenes, [](const auto& scene) { return indices_from(scene.nodes); });
  document.default_scene = index_from(model.defaultScene);
  document.cameras = model.cameras.size();
  return document;
}

}  // namespace

Expected<Document> parse_document(std::span<const std::byte> file, bool is_binary, SceneFolder& folder) {
  FileAccess access{&folder, {}};
  tinygltf::TinyGLTF parser;
  parser.SetFsCallbacks(callbacks_for(access));
  parser.SetImageLoader(keep_image_file, nullptr);
  tinygltf::Model model;
  std::string error, warning;
  const auto size = narrow<unsigned int>(file.size());
  const auto* bytes = reinterpret_cast<const unsigned char*>(file.data());
  const bool parsed = is_binary ? parser.LoadBinaryFromMemory(&model, &error, &warning, bytes, size)
                                : parser.LoadASCIIFromString(&model, &error, &warning,
                                                             reinterpret_cast<const char*>(bytes), size, "");
  if (parsed) return document_from(model, access);
  for (const auto& refusal : access.refused)
    if (error.find(refusal.first) != std::string::npos) return tl::unexpected(refusal.second);
  const bool in_buffers = model.bufferViews.empty() && error.find("image[") == std::string::npos;
  const std::string where = in_buffers ? label("buffer", model.buffers.size()) + ": " : "";
  return malformed(where + printable(error.substr(0, error.find('\n'))));
}

}  // namespace farshade::gltf
