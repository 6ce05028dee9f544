#include "stereo/scene/gltf_parse.h"

#include <charconv>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "stereo/scene/gltf_json.h"

namespace farshade::gltf {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Calls `convert(object, index)` for each object of the list `name`.
template <class To, class Convert>
std::vector<To> each(const JsonObject& parent, std::string_view name, Convert convert,
                     Need need = Need::Optional) {
  std::vector<To> result;
  for (const JsonObject& from : parent.objects(name, need)) result.push_back(convert(from, result.size()));
  return result;
}

/// The extension that compresses buffer views, and its newer name. The object is missing without either.
JsonObject meshopt_of(const JsonObject& from) {
  const JsonObject newer = from.extension("KHR_meshopt_compression");
  return newer ? newer : from.extension("EXT_meshopt_compression");
}

/// True for a buffer for programs that cannot decompress. It may have no bytes, and is not read.
bool is_fallback(const JsonObject& buffer) {
  return meshopt_of(buffer).flag("fallback");
}

/// Only the first buffer of a GLB may be its binary chunk; every other buffer needs a URI.
Expected<Bytes> buffer_from(const JsonObject& from, std::size_t index, std::span<const std::byte> bin,
                            SceneFolder& folder) {
  const std::uint64_t bytes = from.length("byteLength");
  const std::string name = label("buffer", index), uri = from.text("uri");
  if (is_fallback(from)) return Bytes{};
  if (!from.has("uri")) {
    if (index > 0 || bin.empty()) return malformed(name + " has neither a URI nor a GLB's binary chunk");
    if (bytes > bin.size())
      return malformed(name + ": " + std::to_string(bytes) + " bytes are more than the binary chunk has (" +
                       std::to_string(bin.size()) + ")");
    const auto* first = reinterpret_cast<const std::uint8_t*>(bin.data());
    return Bytes(first, first + bytes);
  }
  Expected<Bytes> data = folder.load(uri);
  if (!data) return fail(data.error().fault, name + ": " + data.error().what);
  if (data->size() != bytes)
    return malformed(name + ": its data has " + std::to_string(data->size()) + " bytes, byteLength is " +
                     std::to_string(bytes));
  return data;
}

Expected<Image> image_from(const JsonObject& from, std::size_t index, SceneFolder& folder) {
  Image to{from.text("name"), from.index("bufferView"), {}, {}};
  const std::string uri = from.text("uri");
  if (from.has("bufferView") == from.has("uri"))
    return malformed(label("image", index) + " should have either a URI or a buffer view");
  if (to.view) return to;
  Expected<Bytes> file = folder.load(uri);
  if (file)
    to.file = std::move(*file);
  else if (is_data_uri(uri))
    return fail(file.error().fault, label("image", index, to.name) + ": " + file.error().what);
  else
    to.unreadable = file.error();
  return to;
}

std::shared_ptr<const MeshoptView> meshopt_view_from(const JsonObject& from) {
  return std::make_shared<MeshoptView>(MeshoptView{
      .source = {from.required_index("buffer"), from.size("byteOffset"), from.length("byteLength")},
      .stride = from.length("byteStride"),
      .count = from.length("count"),
      .mode = from.text("mode", Need::Required),
      .filter = from.text("filter", Need::Optional, "NONE")});
}

BufferView view_from(const JsonObject& from, std::size_t index) {
  BufferView to{from.required_index("buffer"), from.size("byteOffset"), from.length("byteLength"),
                from.size("byteStride")};
  if (const JsonObject meshopt = meshopt_of(from)) to.meshopt = meshopt_view_from(meshopt);
  if (from.has("byteStride") && (to.stride < 4 || to.stride > 252 || to.stride % 4 != 0))
    from.refuse(label("buffer view", index) + ": its stride should be a multiple of 4 from 4 to 252");
  return to;
}

struct Shape {
  std::string_view type;
  std::uint32_t rows, columns;
};
constexpr Shape kShapes[] = {{"SCALAR", 1, 1}, {"VEC2", 2, 1}, {"VEC3", 3, 1}, {"VEC4", 4, 1},
                             {"MAT2", 2, 2},   {"MAT3", 3, 3}, {"MAT4", 4, 4}};

Accessor accessor_from(const JsonObject& from, std::size_t index) {
  Accessor to;
  to.view = from.index("bufferView");
  to.offset = from.size("byteOffset");
  to.count = from.length("count");
  to.component = static_cast<Component>(from.required_index("componentType"));
  to.normalized = from.flag("normalized");
  const std::string type = from.text("type", Need::Required);
  const auto* shape = std::ranges::find(kShapes, type, &Shape::type);
  if (shape == std::end(kShapes)) {
    from.refuse(label("accessor", index) + ": unknown type '" + printable(type) + "'");
    return to;
  }
  to.rows = shape->rows;
  to.columns = shape->columns;
  const JsonObject sparse = from.object("sparse");
  if (!sparse) return to;
  const JsonObject indices = sparse.object("indices", Need::Required),
                   values = sparse.object("values", Need::Required);
  to.sparse = Sparse{.count = sparse.required_index("count"),
                     .index_view = indices.required_index("bufferView"),
                     .value_view = values.required_index("bufferView"),
                     .index_offset = indices.index("byteOffset").value_or(0),
                     .value_offset = values.index("byteOffset").value_or(0),
                     .index_component = static_cast<Component>(indices.required_index("componentType"))};
  return to;
}

/// The image of EXT_texture_webp, or else the one that every program can read.
Texture texture_from(const JsonObject& from, std::size_t) {
  const Index webp = from.extension("EXT_texture_webp").index("source");
  return {from.text("name"), webp ? webp : from.index("source"), from.index("sampler")};
}

TextureUse texture_use_from(const JsonObject& from) {
  TextureUse to{.texture = from.required_index("index"), .texcoord = from.index("texCoord").value_or(0)};
  const JsonObject transform = from.extension("KHR_texture_transform");
  to.offset = transform.vector<glm::dvec2>("offset").value_or(to.offset);
  to.scale = transform.vector<glm::dvec2>("scale").value_or(to.scale);
  to.rotation_rad = transform.number("rotation").value_or(0.0);
  to.texcoord = transform.index("texCoord").value_or(to.texcoord);
  return to;
}

Material material_from(const JsonObject& from, std::size_t) {
  Material to{.name = from.text("name"),
              .alpha_mode = from.text("alphaMode", Need::Optional, "OPAQUE"),
              .alpha_cutoff = from.number("alphaCutoff", Sign::NotNegative).value_or(0.5),
              .double_sided = from.flag("doubleSided"),
              .unlit = bool(from.extension("KHR_materials_unlit")),
              .texture = {}};
  const JsonObject surface = from.object("pbrMetallicRoughness");
  to.base_color = surface.vector<glm::dvec4>("baseColorFactor").value_or(to.base_color);
  if (const JsonObject texture = surface.object("baseColorTexture")) to.texture = texture_use_from(texture);
  // The older description of surfaces: its diffuse colour takes the place of the base colour.
  const JsonObject diffuse = from.extension("KHR_materials_pbrSpecularGlossiness");
  to.base_color = diffuse.vector<glm::dvec4>("diffuseFactor").value_or(to.base_color);
  if (const JsonObject texture = diffuse.object("diffuseTexture")) to.texture = texture_use_from(texture);
  return to;
}

std::map<std::uint32_t, std::uint32_t> variants_from(const JsonObject& primitive) {
  std::map<std::uint32_t, std::uint32_t> materials;
  for (const JsonObject& mapping : primitive.extension("KHR_materials_variants").objects("mappings"))
    for (const std::uint32_t variant : mapping.indices("variants"))
      materials[variant] = mapping.required_index("material");
  return materials;
}

std::shared_ptr<const DracoMesh> draco_from(const JsonObject& primitive) {
  const JsonObject from = primitive.extension("KHR_draco_mesh_compression");
  if (!from) return {};
  return std::make_shared<DracoMesh>(
      DracoMesh{from.required_index("bufferView"), from.required_index_map("attributes")});
}

Primitive primitive_from(const JsonObject& from, std::size_t) {
  return {.attributes = from.required_index_map("attributes"),
          .targets = each<MorphTarget>(from, "targets",
                                       [](const JsonObject& target, std::size_t) -> MorphTarget {
                                         return {target.index("POSITION"), target.index("NORMAL")};
                                       }),
          .indices = from.index("indices"),
          .material = from.index("material"),
          .mode = static_cast<Mode>(from.index("mode").value_or(4)),
          .variants = variants_from(from),
          .draco = draco_from(from)};
}

std::shared_ptr<const Instancing> instancing_from(const JsonObject& attributes) {
  return std::make_shared<Instancing>(
      Instancing{attributes.index("TRANSLATION"), attributes.index("ROTATION"), attributes.index("SCALE")});
}

Node node_from(const JsonObject& from, std::size_t index) {
  Node to;
  to.name = from.text("name");
  to.children = from.indices("children");
  to.mesh = from.index("mesh");
  to.camera = from.index("camera");
  to.skin = from.index("skin");
  to.weights = from.numbers("weights");
  if (const JsonObject instancing = from.extension("EXT_mesh_gpu_instancing"))
    to.instancing = instancing_from(instancing.object("attributes", Need::Required));
  if (const JsonObject light = from.extension("KHR_lights_punctual"))
    to.light = light.required_index("light");
  to.translation = from.vector<glm::dvec3>("translation");
  to.scale = from.vector<glm::dvec3>("scale");
  if (const auto r = from.vector<glm::dvec4>("rotation")) to.rotation = glm::dquat(r->w, r->x, r->y, r->z);
  const std::vector<double> matrix = from.numbers("matrix", 16);
  if (matrix.empty()) return to;
  if (to.translation || to.rotation || to.scale)
    from.refuse(label("node", index, to.name) + " has both a matrix and translation, rotation or scale");
  to.matrix.emplace();
  for (int i = 0; i < 16; ++i) (*to.matrix)[i / 4][i % 4] = matrix[static_cast<std::size_t>(i)];
  return to;
}

Light light_from(const JsonObject& from, std::size_t index) {
  Light to{.name = from.text("name"),
           .type = from.text("type", Need::Required),
           .intensity = from.number("intensity", Sign::NotNegative).value_or(1.0),
           .range_m = from.number("range", Sign::Positive)};
  to.color = from.vector<glm::dvec3>("color").value_or(to.color);
  const JsonObject spot = from.object("spot");
  if (to.type == "spot" && !spot) from.refuse(label("light", index, to.name) + " is a spot without a cone");
  to.inner_cone_rad = spot.number("innerConeAngle", Sign::NotNegative).value_or(0.0);
  to.outer_cone_rad = spot.number("outerConeAngle", Sign::NotNegative).value_or(std::numbers::pi / 4);
  return to;
}

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

/// Adds what a pointer of KHR_animation_pointer means.
void add_pointer(std::uint32_t sampler, const std::string& pointer, Animation& to) {
  constexpr std::string_view kPaths[] = {"translation", "rotation", "scale", "weights"};
  constexpr std::string_view kProperties[] = {"color", "intensity", "range", "spot/innerConeAngle",
                                              "spot/outerConeAngle"};
  if (const auto node = pointed(pointer, "/nodes/", kPaths))
    to.channels.push_back({sampler, node->index, node->property});
  else if (const auto light = pointed(pointer, "/extensions/KHR_lights_punctual/lights/", kProperties))
    to.lights.push_back({sampler, light->index, light->property});
  else
    to.still.push_back(pointer);
}

/// Leaves out channels without a target node, as the specification asks.
Animation animation_from(const JsonObject& from, std::size_t) {
  Animation to{.name = from.text("name")};
  for (const JsonObject& channel : from.objects("channels", Need::Required)) {
    const JsonObject target = channel.object("target", Need::Required);
    const std::uint32_t sampler = channel.required_index("sampler");
    const std::string path = target.text("path", Need::Required);
    if (path == "pointer")
      add_pointer(sampler, target.extension("KHR_animation_pointer").text("pointer"), to);
    else if (const Index node = target.index("node"))
      to.channels.push_back({sampler, *node, path});
  }
  to.samplers = each<AnimationSampler>(
      from, "samplers",
      [](const JsonObject& sampler, std::size_t) -> AnimationSampler {
        return {sampler.required_index("input"), sampler.required_index("output"),
                sampler.text("interpolation", Need::Optional, "LINEAR")};
      },
      Need::Required);
  return to;
}

void check_version(const JsonObject& asset) {
  const std::string version = asset.text("version", Need::Required),
                    least = asset.text("minVersion", Need::Optional, "2.0");
  if (version.starts_with("2.") && least == "2.0") return;
  asset.refuse("glTF version " + printable(least == "2.0" ? version : least) + ", only 2.0 is read",
               Fault::Unsupported);
}

constexpr std::string_view kKnownExtensions[] = {
    "EXT_mesh_gpu_instancing",    "EXT_meshopt_compression", "EXT_texture_webp",
    "KHR_draco_mesh_compression", "KHR_lights_punctual",     "KHR_materials_variants",
    "KHR_mesh_quantization",      "KHR_meshopt_compression", "KHR_texture_transform"};

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
    {"KHR_animation_pointer", ""},  // warn_of_still
};

const LookExtension* look_of(std::string_view name) {
  const auto* found = std::ranges::find_if(
      kLookExtensions, [&](const LookExtension& look) { return name.starts_with(look.name); });
  return found == std::end(kLookExtensions) ? nullptr : found;
}

void check_extensions(const JsonObject& root) {
  for (const std::string& name : root.texts("extensionsRequired"))
    if (!is_known(name) && !look_of(name))
      return root.refuse(
          "the required extension '" + printable(name) + "' is not supported: export the file without it",
          Fault::Unsupported);
}

/// A warning for each used extension that changes the look.
std::vector<std::string> warnings_of(const JsonObject& root) {
  std::vector<std::string> warnings;
  const std::vector<std::string> listed = root.texts("extensionsUsed");
  for (const std::string& name : std::set<std::string>(listed.begin(), listed.end())) {
    const LookExtension* const look = is_known(name) ? nullptr : look_of(name);
    if (look && !look->without.empty())
      warnings.push_back(printable(name) + " is not drawn: " + std::string(look->without));
  }
  return warnings;
}

/// glTF 1.0 has numbers as versions, or none, and objects instead of lists.
bool is_version_1(const nlohmann::json& root) {
  const auto asset = root.find("asset"), meshes = root.find("meshes");
  if (asset != root.end() && asset->is_object() && asset->contains("version") &&
      (*asset)["version"].is_number())
    return true;
  return meshes != root.end() && meshes->is_object();
}

std::string name_from(const JsonObject& from, std::size_t) {
  return from.text("name");
}

void warn_of_still(Document& document) {
  for (const Animation& animation : document.animations)
    if (!animation.still.empty())
      return document.warnings.push_back("KHR_animation_pointer: only nodes and lights are animated, so '" +
                                         printable(animation.still.front()) + "' and the like stand still");
}

/// Everything that needs no further file.
Document description_from(const JsonObject& root) {
  Document document;
  document.warnings = warnings_of(root);
  document.views = each<BufferView>(root, "bufferViews", view_from);
  document.accessors = each<Accessor>(root, "accessors", accessor_from);
  document.texture_samplers =
      each<TextureSampler>(root, "samplers", [](const JsonObject& sampler, std::size_t) -> TextureSampler {
        return {sampler.index("wrapS").value_or(10497), sampler.index("wrapT").value_or(10497)};
      });
  document.textures = each<Texture>(root, "textures", texture_from);
  document.materials = each<Material>(root, "materials", material_from);
  document.meshes = each<Mesh>(root, "meshes", [](const JsonObject& mesh, std::size_t) -> Mesh {
    return {mesh.text("name"), each<Primitive>(mesh, "primitives", primitive_from, Need::Required),
            mesh.numbers("weights")};
  });
  document.nodes = each<Node>(root, "nodes", node_from);
  document.skins = each<Skin>(root, "skins", [](const JsonObject& skin, std::size_t) -> Skin {
    return {skin.text("name"), skin.indices("joints"), skin.index("inverseBindMatrices")};
  });
  if (const JsonObject lights = root.extension("KHR_lights_punctual"))
    document.lights = each<Light>(lights, "lights", light_from, Need::Required);
  document.animations = each<Animation>(root, "animations", animation_from);
  warn_of_still(document);
  document.scenes = each<std::vector<std::uint32_t>>(
      root, "scenes", [](const JsonObject& scene, std::size_t) { return scene.indices("nodes"); });
  document.default_scene = root.index("scene");
  document.scene_names = each<std::string>(root, "scenes", name_from);
  document.cameras = each<std::string>(root, "cameras", name_from);
  if (const JsonObject variants = root.extension("KHR_materials_variants"))
    document.variants = each<std::string>(variants, "variants", name_from);
  return document;
}

Expected<nlohmann::json> json_from(std::string_view text) try {
  nlohmann::json root = nlohmann::json::parse(text);
  if (!root.is_object()) return malformed("JSON: the file is not an object");
  return root;
} catch (const nlohmann::json::exception& refusal) {
  const std::string_view what = refusal.what();
  const auto after_tag = what.find("] ");
  return malformed("JSON: " + printable(after_tag == what.npos ? what : what.substr(after_tag + 2)));
}

/// Appends the files that the list `name` names to `files`, if nothing is wrong before.
template <class File, class Load>
void load_files(const JsonObject& root, std::string_view name, const Checked& verdict,
                std::vector<File>& files, Load load) {
  for (const JsonObject& from : root.objects(name)) {
    if (!verdict) return;
    Expected<File> file = load(from, files.size());
    if (!file) return from.refuse(file.error().what, file.error().fault);
    files.push_back(std::move(*file));
  }
}

}  // namespace

Expected<Document> parse_document(std::string_view text, std::span<const std::byte> bin,
                                  SceneFolder& folder) {
  const Expected<nlohmann::json> json = json_from(text);
  if (!json) return tl::unexpected(json.error());
  Checked verdict;
  const JsonObject root(*json, "", verdict);
  if (is_version_1(*json)) return fail(Fault::Unsupported, "glTF version 1.0, only 2.0 is read");
  // What the file needs comes first: other faults often follow from it.
  check_version(root.object("asset", Need::Required));
  check_extensions(root);
  if (!verdict) return tl::unexpected(verdict.error());
  Document document = description_from(root);
  load_files(root, "buffers", verdict, document.buffers,
             [&](const JsonObject& from, std::size_t i) { return buffer_from(from, i, bin, folder); });
  load_files(root, "images", verdict, document.images,
             [&](const JsonObject& from, std::size_t i) { return image_from(from, i, folder); });
  if (!verdict) return tl::unexpected(verdict.error());
  return document;
}

}  // namespace farshade::gltf
