#include "stereo/scene/gltf_parse.h"

#include <iterator>
#include <numbers>

#include "stereo/scene/gltf_json.h"

namespace farshade::gltf {
namespace {

using Bytes = std::vector<std::uint8_t>;

template <class To, class Convert>
std::vector<To> each(const json::array_t& list, Convert convert) {
  std::vector<To> result;
  result.reserve(list.size());
  std::transform(list.begin(), list.end(), std::back_inserter(result), convert);
  return result;
}

std::uint32_t number_in(const json& object, std::string_view name, std::uint32_t otherwise = 0) {
  return value_or(object, name, otherwise);
}

std::uint64_t size_in(const json& object, std::string_view name) {
  return value_or(object, name, std::uint64_t{0});
}

/// The N numbers of the array `name`; the schema checked how many there are.
template <class Vector>
std::optional<Vector> vector_in(const json& object, std::string_view name) {
  const json& value = member(object, name);
  if (value.is_null()) return std::nullopt;
  Vector vector{};
  for (int i = 0; i < Vector::length(); ++i) vector[i] = value.at(static_cast<std::size_t>(i)).get<double>();
  return vector;
}

std::vector<std::uint32_t> indices_in(const json& object, std::string_view name) {
  return each<std::uint32_t>(list_in(object, name), [](const json& i) { return i.get<std::uint32_t>(); });
}

bool has_weights(const json& object) {
  const json::array_t& weights = list_in(object, "weights");
  return std::any_of(weights.begin(), weights.end(), [](const json& w) { return w.get<double>() != 0.0; });
}

Expected<Bytes> buffer_from(const json& from, std::size_t index, std::span<const std::byte> bin,
                            SceneFolder& folder) {
  const std::uint64_t bytes = size_in(from, "byteLength");
  const std::string name = label("buffer", index);
  if (!from.contains("uri")) {
    if (bytes > bin.size())
      return malformed(name + ": " + std::to_string(bytes) + " bytes are more than the binary chunk has (" +
                       std::to_string(bin.size()) + ")");
    const auto* first = reinterpret_cast<const std::uint8_t*>(bin.data());
    return Bytes(first, first + bytes);
  }
  Expected<Bytes> data = folder.load(text_in(from, "uri"));
  if (!data) return fail(data.error().fault, name + ": " + data.error().what);
  if (data->size() != bytes)
    return malformed(name + ": its data has " + std::to_string(data->size()) + " bytes, byteLength is " +
                     std::to_string(bytes));
  return data;
}

Expected<Image> image_from(const json& from, std::size_t index, SceneFolder& folder) {
  Image to{text_in(from, "name"), index_in(from, "bufferView"), {}, {}};
  if (to.view) return to;
  const std::string uri = text_in(from, "uri");
  Expected<Bytes> file = folder.load(uri);
  if (file)
    to.file = std::move(*file);
  else if (is_data_uri(uri))
    return fail(file.error().fault, label("image", index, to.name) + ": " + file.error().what);
  else
    to.unreadable = file.error();
  return to;
}

/// The shape of an element of the types that the schema check knows.
void set_shape(Accessor& to, std::string_view type) {
  const auto digit = static_cast<std::uint32_t>(type.back() - '0');
  to.rows = type == "SCALAR" ? 1 : digit;
  to.columns = type.starts_with("MAT") ? digit : 1;
}

Accessor accessor_from(const json& from) {
  Accessor to;
  to.view = index_in(from, "bufferView");
  to.offset = size_in(from, "byteOffset");
  to.count = size_in(from, "count");
  to.component = static_cast<Component>(number_in(from, "componentType"));
  to.normalized = value_or(from, "normalized", false);
  set_shape(to, member(from, "type").get_ref<const std::string&>());
  const json& sparse = member(from, "sparse");
  if (sparse.is_null()) return to;
  const json &indices = member(sparse, "indices"), &values = member(sparse, "values");
  to.sparse = Sparse{.count = size_in(sparse, "count"),
                     .index_view = number_in(indices, "bufferView"),
                     .value_view = number_in(values, "bufferView"),
                     .index_offset = size_in(indices, "byteOffset"),
                     .value_offset = size_in(values, "byteOffset"),
                     .index_component = static_cast<Component>(number_in(indices, "componentType"))};
  return to;
}

TextureUse texture_use_from(const json& from) {
  TextureUse to{.texture = number_in(from, "index"), .texcoord = number_in(from, "texCoord")};
  const json& transform = extension_in(from, "KHR_texture_transform");
  if (transform.is_null()) return to;
  to.offset = vector_in<glm::dvec2>(transform, "offset").value_or(to.offset);
  to.scale = vector_in<glm::dvec2>(transform, "scale").value_or(to.scale);
  to.rotation_rad = value_or(transform, "rotation", 0.0);
  to.texcoord = number_in(transform, "texCoord", to.texcoord);
  return to;
}

Material material_from(const json& from) {
  Material to{.name = text_in(from, "name"),
              .alpha_mode = text_in(from, "alphaMode", "OPAQUE"),
              .alpha_cutoff = value_or(from, "alphaCutoff", 0.5),
              .double_sided = value_or(from, "doubleSided", false),
              .texture = {}};
  const json& surface = member(from, "pbrMetallicRoughness");
  if (surface.is_null()) return to;
  to.base_color = vector_in<glm::dvec4>(surface, "baseColorFactor").value_or(to.base_color);
  if (const json& texture = member(surface, "baseColorTexture"); !texture.is_null())
    to.texture = texture_use_from(texture);
  return to;
}

Primitive primitive_from(const json& from) {
  Primitive to{.attributes = {},
               .indices = index_in(from, "indices"),
               .material = index_in(from, "material"),
               .mode = static_cast<Mode>(number_in(from, "mode", 4))};
  for (const auto& [semantic, accessor] : member(from, "attributes").items())
    to.attributes.emplace(semantic, accessor.get<std::uint32_t>());
  return to;
}

Node node_from(const json& from) {
  Node to;
  to.name = text_in(from, "name");
  to.children = indices_in(from, "children");
  to.mesh = index_in(from, "mesh");
  to.camera = index_in(from, "camera");
  to.skin = index_in(from, "skin");
  to.morphed = has_weights(from);
  if (const json& light = extension_in(from, "KHR_lights_punctual"); !light.is_null())
    to.light = index_in(light, "light");
  to.translation = vector_in<glm::dvec3>(from, "translation");
  to.scale = vector_in<glm::dvec3>(from, "scale");
  if (const auto r = vector_in<glm::dvec4>(from, "rotation"))
    to.rotation = glm::dquat(r->w, r->x, r->y, r->z);
  const json::array_t& matrix = list_in(from, "matrix");
  if (matrix.empty()) return to;
  to.matrix.emplace();
  for (int i = 0; i < 16; ++i) (*to.matrix)[i / 4][i % 4] = matrix[static_cast<std::size_t>(i)].get<double>();
  return to;
}

Light light_from(const json& from) {
  Light to{.name = text_in(from, "name"), .type = text_in(from, "type"), .range_m = {}};
  to.color = vector_in<glm::dvec3>(from, "color").value_or(to.color);
  to.intensity = value_or(from, "intensity", 1.0);
  if (const json& range = member(from, "range"); !range.is_null()) to.range_m = range.get<double>();
  const json& spot = member(from, "spot");
  if (spot.is_null()) return to;
  to.inner_cone_rad = value_or(spot, "innerConeAngle", 0.0);
  to.outer_cone_rad = value_or(spot, "outerConeAngle", std::numbers::pi / 4);
  return to;
}

/// Leaves out channels without a target node, as the specification asks.
Animation animation_from(const json& from) {
  Animation to{text_in(from, "name"), {}, {}};
  for (const json& channel : list_in(from, "channels")) {
    const json& target = member(channel, "target");
    if (const Index node = index_in(target, "node"))
      to.channels.push_back({number_in(channel, "sampler"), *node, text_in(target, "path")});
  }
  to.samplers =
      each<AnimationSampler>(list_in(from, "samplers"), [](const json& sampler) -> AnimationSampler {
        return {number_in(sampler, "input"), number_in(sampler, "output"),
                text_in(sampler, "interpolation", "LINEAR")};
      });
  return to;
}

/// Everything that needs no further file.
Document description_from(const json& root) {
  Document document;
  for (const json& name : list_in(root, "extensionsRequired"))
    document.required_extensions.push_back(name.get<std::string>());
  document.views = each<BufferView>(list_in(root, "bufferViews"), [](const json& view) -> BufferView {
    return {number_in(view, "buffer"), size_in(view, "byteOffset"), size_in(view, "byteLength"),
            size_in(view, "byteStride")};
  });
  document.accessors = each<Accessor>(list_in(root, "accessors"), accessor_from);
  document.texture_samplers =
      each<TextureSampler>(list_in(root, "samplers"), [](const json& sampler) -> TextureSampler {
        return {number_in(sampler, "wrapS", 10497), number_in(sampler, "wrapT", 10497)};
      });
  document.textures = each<Texture>(list_in(root, "textures"), [](const json& texture) -> Texture {
    return {text_in(texture, "name"), index_in(texture, "source"), index_in(texture, "sampler")};
  });
  document.materials = each<Material>(list_in(root, "materials"), material_from);
  document.meshes = each<Mesh>(list_in(root, "meshes"), [](const json& mesh) -> Mesh {
    return {text_in(mesh, "name"), each<Primitive>(list_in(mesh, "primitives"), primitive_from),
            has_weights(mesh)};
  });
  document.nodes = each<Node>(list_in(root, "nodes"), node_from);
  if (const json& lights = extension_in(root, "KHR_lights_punctual"); !lights.is_null())
    document.lights = each<Light>(list_in(lights, "lights"), light_from);
  document.animations = each<Animation>(list_in(root, "animations"), animation_from);
  document.scenes = each<std::vector<std::uint32_t>>(
      list_in(root, "scenes"), [](const json& scene) { return indices_in(scene, "nodes"); });
  document.default_scene = index_in(root, "scene");
  document.cameras = list_in(root, "cameras").size();
  return document;
}

}  // namespace

Expected<Document> parse_document(const json& root, std::span<const std::byte> bin, SceneFolder& folder) {
  Document document = description_from(root);
  for (const json& from : list_in(root, "buffers")) {
    Expected<Bytes> buffer = buffer_from(from, document.buffers.size(), bin, folder);
    if (!buffer) return tl::unexpected(buffer.error());
    document.buffers.push_back(std::move(*buffer));
  }
  for (const json& from : list_in(root, "images")) {
    Expected<Image> image = image_from(from, document.images.size(), folder);
    if (!image) return tl::unexpected(image.error());
    document.images.push_back(std::move(*image));
  }
  return document;
}

}  // namespace farshade::gltf
