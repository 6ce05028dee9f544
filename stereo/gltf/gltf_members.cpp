#include "stereo/gltf/gltf_members.h"

#include <limits>
#include <nlohmann/json.hpp>
#include <span>

namespace farshade::gltf {
namespace {

using nlohmann::json;

constexpr std::uint64_t kMaxSize = (std::uint64_t{1} << 53) - 1;  // a double holds it exactly
constexpr double kMaxNumber = 1e30;                               // a float holds it, a double its products

bool is_whole(const json& value, std::uint64_t least, std::uint64_t most) {
  return value.is_number_unsigned() && value.get<std::uint64_t>() >= least &&
         value.get<std::uint64_t>() <= most;
}
bool is_index(const json& value) {
  return is_whole(value, 0, kMaxIndex);
}
bool is_text(const json& value) {
  return value.is_string();
}
bool is_object(const json& value) {
  return value.is_object();
}
bool is_within(const json& value, double least) {
  return value.is_number() && value.get<double>() >= least && value.get<double>() <= kMaxNumber;
}
bool is_number(const json& value) {
  return is_within(value, -kMaxNumber);
}
template <bool (*is_element)(const json&)>
bool is_list_of(const json& value) {
  return value.is_array() && std::all_of(value.begin(), value.end(), is_element);
}
template <std::size_t count>
bool is_vector(const json& value) {
  return value.size() == count && is_list_of<is_number>(value);
}

/// A test of a value, and what passes it in words.
struct Type {
  bool (*fits)(const json&);
  const char* words;
};
constexpr Type kIndex{is_index, "a whole number from 0 to 2147483647"};
constexpr Type kLength{[](const json& value) { return is_whole(value, 1, kMaxIndex); },
                       "a whole number from 1 to 2147483647"};
constexpr Type kSize{[](const json& value) { return is_whole(value, 0, kMaxSize); },
                     "a whole number from 0 to 9007199254740991"};
constexpr Type kLargeLength{[](const json& value) { return is_whole(value, 1, kMaxSize); },
                            "a whole number from 1 to 9007199254740991"};
constexpr Type kNumber{is_number, "a number within +-1e30"};
constexpr Type kNotNegative{[](const json& value) { return is_within(value, 0); }, "a number from 0 to 1e30"};
constexpr Type kPositive{
    [](const json& value) { return is_within(value, double{std::numeric_limits<float>::min()}); },
    "a number above 0, up to 1e30"};
constexpr Type kFlag{[](const json& value) { return value.is_boolean(); }, "true or false"};
constexpr Type kText{is_text, "a text"}, kTexts{is_list_of<is_text>, "a list of texts"};
constexpr Type kIndices{is_list_of<is_index>, "a list of indices"};
constexpr Type kNumbers{is_list_of<is_number>, "a list of numbers within +-1e30"};
constexpr Type kVector2{is_vector<2>, "a list of 2 numbers within +-1e30"},
    kVector3{is_vector<3>, "a list of 3 numbers within +-1e30"},
    kVector4{is_vector<4>, "a list of 4 numbers within +-1e30"},
    kMatrix4{is_vector<16>, "a list of 16 numbers within +-1e30"};
constexpr Type kIndexMap{
    [](const json& value) { return value.is_object() && std::all_of(value.begin(), value.end(), is_index); },
    "an object whose values are indices"};
constexpr Type kObject{is_object, "an object"}, kObjects{is_list_of<is_object>, "a list of objects"};

enum class Need { Optional, Required };

struct Member {
  std::string_view name;
  const Type* type;
  Need need = Need::Optional;
  std::span<const Member> inner{};  ///< of kObject and kObjects
};

constexpr Member optional(std::string_view name, const Type& type) {
  return {name, &type};
}
constexpr Member required(std::string_view name, const Type& type) {
  return {name, &type, Need::Required};
}
constexpr Member object(std::string_view name, std::span<const Member> inner, Need need = Need::Optional) {
  return {name, &kObject, need, inner};
}
constexpr Member objects(std::string_view name, std::span<const Member> inner, Need need = Need::Optional) {
  return {name, &kObjects, need, inner};
}
constexpr Member kName = optional("name", kText);
constexpr Member kNamed[] = {kName};

constexpr Member kAsset[] = {required("version", kText), optional("minVersion", kText)};
constexpr Member kNeeds[] = {object("asset", kAsset, Need::Required), optional("extensionsUsed", kTexts),
                             optional("extensionsRequired", kTexts)};

constexpr Member kFallback[] = {optional("fallback", kFlag)};
constexpr Member kBufferExtensions[] = {object("EXT_meshopt_compression", kFallback),
                                        object("KHR_meshopt_compression", kFallback)};
constexpr Member kBuffer[] = {required("byteLength", kLargeLength), optional("uri", kText),
                              object("extensions", kBufferExtensions)};
constexpr Member kMeshopt[] = {required("buffer", kIndex),      optional("byteOffset", kIndex),
                               required("byteLength", kLength), required("byteStride", kLength),
                               required("count", kLength),      required("mode", kText),
                               optional("filter", kText)};
constexpr Member kViewExtensions[] = {object("EXT_meshopt_compression", kMeshopt),
                                      object("KHR_meshopt_compression", kMeshopt)};
constexpr Member kBufferView[] = {required("buffer", kIndex), optional("byteOffset", kSize),
                                  required("byteLength", kLargeLength), optional("byteStride", kSize),
                                  object("extensions", kViewExtensions)};

constexpr Member kSparseIndices[] = {required("bufferView", kIndex), optional("byteOffset", kIndex),
                                     required("componentType", kIndex)};
constexpr Member kSparseValues[] = {required("bufferView", kIndex), optional("byteOffset", kIndex)};
constexpr Member kSparse[] = {required("count", kIndex), object("indices", kSparseIndices, Need::Required),
                              object("values", kSparseValues, Need::Required)};
constexpr Member kAccessor[] = {optional("bufferView", kIndex),    optional("byteOffset", kSize),
                                required("componentType", kIndex), optional("normalized", kFlag),
                                required("count", kLargeLength),   required("type", kText),
                                object("sparse", kSparse)};

constexpr Member kDraco[] = {required("bufferView", kIndex), required("attributes", kIndexMap)};
constexpr Member kMapping[] = {optional("variants", kIndices), required("material", kIndex)};
constexpr Member kMappings[] = {objects("mappings", kMapping)};
constexpr Member kPrimitiveExtensions[] = {object("KHR_draco_mesh_compression", kDraco),
                                           object("KHR_materials_variants", kMappings)};
constexpr Member kMorphTarget[] = {optional("POSITION", kIndex), optional("NORMAL", kIndex)};
constexpr Member kPrimitive[] = {
    required("attributes", kIndexMap), optional("indices", kIndex),
    optional("material", kIndex),      optional("mode", kIndex),
    objects("targets", kMorphTarget),  object("extensions", kPrimitiveExtensions)};
constexpr Member kMesh[] = {kName, objects("primitives", kPrimitive, Need::Required),
                            optional("weights", kNumbers)};

constexpr Member kInstances[] = {optional("TRANSLATION", kIndex), optional("ROTATION", kIndex),
                                 optional("SCALE", kIndex)};
constexpr Member kInstancing[] = {object("attributes", kInstances, Need::Required)};
constexpr Member kNodeLight[] = {required("light", kIndex)};
constexpr Member kVisibility[] = {optional("visible", kFlag)};
constexpr Member kNodeExtensions[] = {object("EXT_mesh_gpu_instancing", kInstancing),
                                      object("KHR_lights_punctual", kNodeLight),
                                      object("KHR_node_visibility", kVisibility)};
constexpr Member kNode[] = {kName,
                            optional("children", kIndices),
                            optional("mesh", kIndex),
                            optional("camera", kIndex),
                            optional("skin", kIndex),
                            optional("weights", kNumbers),
                            optional("translation", kVector3),
                            optional("rotation", kVector4),
                            optional("scale", kVector3),
                            optional("matrix", kMatrix4),
                            object("extensions", kNodeExtensions)};
constexpr Member kScene[] = {kName, optional("nodes", kIndices)};
constexpr Member kSkin[] = {kName, required("joints", kIndices), optional("inverseBindMatrices", kIndex)};

constexpr Member kTransform[] = {optional("offset", kVector2), optional("scale", kVector2),
                                 optional("rotation", kNumber), optional("texCoord", kIndex)};
constexpr Member kTextureInfoExtensions[] = {object("KHR_texture_transform", kTransform)};
constexpr Member kTextureInfo[] = {required("index", kIndex), optional("texCoord", kIndex),
                                   object("extensions", kTextureInfoExtensions)};
constexpr Member kSurface[] = {optional("baseColorFactor", kVector4),
                               object("baseColorTexture", kTextureInfo)};
constexpr Member kDiffuse[] = {optional("diffuseFactor", kVector4), object("diffuseTexture", kTextureInfo)};
constexpr Member kMaterialExtensions[] = {object("KHR_materials_unlit", {}),
                                          object("KHR_materials_pbrSpecularGlossiness", kDiffuse)};
constexpr Member kMaterial[] = {kName,
                                optional("alphaMode", kText),
                                optional("alphaCutoff", kNotNegative),
                                optional("doubleSided", kFlag),
                                object("pbrMetallicRoughness", kSurface),
                                object("extensions", kMaterialExtensions)};
constexpr Member kImage[] = {kName, optional("uri", kText), optional("bufferView", kIndex)};
constexpr Member kWebp[] = {optional("source", kIndex)};
constexpr Member kTextureExtensions[] = {object("EXT_texture_webp", kWebp)};
constexpr Member kTexture[] = {kName, optional("source", kIndex), optional("sampler", kIndex),
                               object("extensions", kTextureExtensions)};
constexpr Member kSampler[] = {optional("wrapS", kIndex), optional("wrapT", kIndex)};

constexpr Member kPointer[] = {optional("pointer", kText)};
constexpr Member kTargetExtensions[] = {object("KHR_animation_pointer", kPointer)};
constexpr Member kTarget[] = {optional("node", kIndex), required("path", kText),
                              object("extensions", kTargetExtensions)};
constexpr Member kChannel[] = {required("sampler", kIndex), object("target", kTarget, Need::Required)};
constexpr Member kAnimationSampler[] = {required("input", kIndex), required("output", kIndex),
                                        optional("interpolation", kText)};
constexpr Member kAnimation[] = {kName, objects("channels", kChannel, Need::Required),
                                 objects("samplers", kAnimationSampler, Need::Required)};

constexpr Member kSpot[] = {optional("innerConeAngle", kNotNegative),
                            optional("outerConeAngle", kNotNegative)};
constexpr Member kLight[] = {kName,
                             required("type", kText),
                             optional("color", kVector3),
                             optional("intensity", kNotNegative),
                             optional("range", kPositive),
                             object("spot", kSpot)};
constexpr Member kLights[] = {objects("lights", kLight, Need::Required)};
constexpr Member kVariants[] = {objects("variants", kNamed)};
constexpr Member kRootExtensions[] = {object("KHR_lights_punctual", kLights),
                                      object("KHR_materials_variants", kVariants)};
constexpr Member kRoot[] = {kNeeds[0],
                            kNeeds[1],
                            objects("buffers", kBuffer),
                            objects("bufferViews", kBufferView),
                            objects("accessors", kAccessor),
                            objects("samplers", kSampler),
                            objects("textures", kTexture),
                            objects("images", kImage),
                            objects("materials", kMaterial),
                            objects("meshes", kMesh),
                            objects("nodes", kNode),
                            objects("skins", kSkin),
                            object("extensions", kRootExtensions),
                            objects("animations", kAnimation),
                            objects("scenes", kScene),
                            optional("scene", kIndex),
                            objects("cameras", kNamed)};

/// Where a value is. It becomes a text only if the value is refused.
struct Place {
  const Place* parent = nullptr;
  std::string_view name{};
  std::optional<std::size_t> element{};

  [[nodiscard]] std::string text() const {
    if (!parent) return "";
    if (element) return parent->text() + "[" + std::to_string(*element) + "]";
    const std::string before = parent->text();
    return (before.empty() ? "" : before + ".") + std::string(name);
  }
};

Checked check_object(const json& object, std::span<const Member> members, const Place& place) {
  for (const Member& member : members) {
    const Place here{&place, member.name};
    const auto found = object.find(member.name);
    if (found == object.end()) {
      if (member.need == Need::Required) return malformed(here.text() + " is missing");
      continue;
    }
    if (!member.type->fits(*found)) return malformed(here.text() + " should be " + member.type->words);
    if (member.type == &kObject)
      if (auto checked = check_object(*found, member.inner, here); !checked) return checked;
    if (member.type != &kObjects) continue;
    for (std::size_t i = 0; i < found->size(); ++i)
      if (auto checked = check_object((*found)[i], member.inner, {&here, {}, i}); !checked) return checked;
  }
  return {};
}

/// tinygltf stores whole numbers of extensions in 32 bits, so numbers that may be fractions become
/// floating-point numbers.
void make_fractions(const Type& type, json& value) {
  if (&type == &kNumber || &type == &kNotNegative || &type == &kPositive) value = value.get<double>();
  if (value.is_array() && &type != &kIndices)
    for (json& element : value)
      if (element.is_number()) element = element.get<double>();
}

void remove_others(json& object, std::span<const Member> members) {
  for (auto item = object.begin(); item != object.end();) {
    const auto known = std::ranges::find(members, std::string_view(item.key()), &Member::name);
    if (known == members.end()) {
      item = object.erase(item);
      continue;
    }
    make_fractions(*known->type, *item);
    // tinygltf ends names at a zero byte, so "POSITION\0" would be POSITION.
    if (known->type == &kIndexMap)
      for (auto entry = item->begin(); entry != item->end();)
        entry = entry.key().find('\0') == std::string::npos ? std::next(entry) : item->erase(entry);
    if (known->type == &kObject) remove_others(*item, known->inner);
    if (known->type == &kObjects)
      for (json& element : *item) remove_others(element, known->inner);
    ++item;
  }
}

}  // namespace

Checked check_needs(const json& root) {
  return check_object(root, kNeeds, {});
}

Checked keep_members(json& root) {
  if (auto checked = check_object(root, kRoot, {}); !checked) return checked;
  remove_others(root, kRoot);
  return {};
}

}  // namespace farshade::gltf
