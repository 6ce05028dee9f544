#include "stereo/scene/gltf_members.h"

#include <limits>
#include <nlohmann/json.hpp>
#include <span>

namespace farshade::gltf {
namespace {

using nlohmann::json;

constexpr std::uint64_t kMaxIndex = (std::uint64_t{1} << 31) - 1;  // an int holds it
constexpr std::uint64_t kMaxSize = (std::uint64_t{1} << 53) - 1;   // a double holds it exactly
constexpr double kMaxNumber = 1e30;                                // a float holds it, a double its products

enum class Kind {
  Index,
  Length,  ///< an index above 0
  Size,
  LargeLength,  ///< a size above 0
  Number,
  NotNegative,
  Positive,
  Flag,
  Text,
  Texts,
  Indices,
  Numbers,
  IndexMap,
  Object,
  Objects
};
enum class Need { Optional, Required };

struct Member {
  std::string_view name;
  Kind kind;
  Need need = Need::Optional;
  std::span<const Member> inner{};  ///< of Object and Objects
  std::size_t count = 0;            ///< of Numbers; 0: any
};

constexpr Member optional(std::string_view name, Kind kind) {
  return {name, kind};
}
constexpr Member required(std::string_view name, Kind kind) {
  return {name, kind, Need::Required};
}
constexpr Member numbers(std::string_view name, std::size_t count) {
  return {name, Kind::Numbers, Need::Optional, {}, count};
}
constexpr Member object(std::string_view name, std::span<const Member> inner) {
  return {name, Kind::Object, Need::Optional, inner};
}
constexpr Member required_object(std::string_view name, std::span<const Member> inner) {
  return {name, Kind::Object, Need::Required, inner};
}
constexpr Member objects(std::string_view name, std::span<const Member> inner) {
  return {name, Kind::Objects, Need::Optional, inner};
}
constexpr Member required_objects(std::string_view name, std::span<const Member> inner) {
  return {name, Kind::Objects, Need::Required, inner};
}
constexpr Member kName = optional("name", Kind::Text);
constexpr Member kNamed[] = {kName};

constexpr Member kAsset[] = {required("version", Kind::Text), optional("minVersion", Kind::Text)};
constexpr Member kNeeds[] = {required_object("asset", kAsset), optional("extensionsUsed", Kind::Texts),
                             optional("extensionsRequired", Kind::Texts)};

constexpr Member kFallback[] = {optional("fallback", Kind::Flag)};
constexpr Member kBufferExtensions[] = {object("EXT_meshopt_compression", kFallback),
                                        object("KHR_meshopt_compression", kFallback)};
constexpr Member kBuffer[] = {required("byteLength", Kind::LargeLength), optional("uri", Kind::Text),
                              object("extensions", kBufferExtensions)};
constexpr Member kMeshopt[] = {required("buffer", Kind::Index),      optional("byteOffset", Kind::Index),
                               required("byteLength", Kind::Length), required("byteStride", Kind::Length),
                               required("count", Kind::Length),      required("mode", Kind::Text),
                               optional("filter", Kind::Text)};
constexpr Member kViewExtensions[] = {object("EXT_meshopt_compression", kMeshopt),
                                      object("KHR_meshopt_compression", kMeshopt)};
constexpr Member kBufferView[] = {required("buffer", Kind::Index), optional("byteOffset", Kind::Size),
                                  required("byteLength", Kind::LargeLength),
                                  optional("byteStride", Kind::Size), object("extensions", kViewExtensions)};

constexpr Member kSparseIndices[] = {required("bufferView", Kind::Index), optional("byteOffset", Kind::Index),
                                     required("componentType", Kind::Index)};
constexpr Member kSparseValues[] = {required("bufferView", Kind::Index), optional("byteOffset", Kind::Index)};
constexpr Member kSparse[] = {required("count", Kind::Index), required_object("indices", kSparseIndices),
                              required_object("values", kSparseValues)};
constexpr Member kAccessor[] = {optional("bufferView", Kind::Index),
                                optional("byteOffset", Kind::Size),
                                required("componentType", Kind::Index),
                                optional("normalized", Kind::Flag),
                                required("count", Kind::LargeLength),
                                required("type", Kind::Text),
                                object("sparse", kSparse)};

constexpr Member kDraco[] = {required("bufferView", Kind::Index), required("attributes", Kind::IndexMap)};
constexpr Member kMapping[] = {optional("variants", Kind::Indices), required("material", Kind::Index)};
constexpr Member kMappings[] = {objects("mappings", kMapping)};
constexpr Member kPrimitiveExtensions[] = {object("KHR_draco_mesh_compression", kDraco),
                                           object("KHR_materials_variants", kMappings)};
constexpr Member kMorphTarget[] = {optional("POSITION", Kind::Index), optional("NORMAL", Kind::Index)};
constexpr Member kPrimitive[] = {
    required("attributes", Kind::IndexMap), optional("indices", Kind::Index),
    optional("material", Kind::Index),      optional("mode", Kind::Index),
    objects("targets", kMorphTarget),       object("extensions", kPrimitiveExtensions)};
constexpr Member kMesh[] = {kName, required_objects("primitives", kPrimitive),
                            optional("weights", Kind::Numbers)};

constexpr Member kInstances[] = {optional("TRANSLATION", Kind::Index), optional("ROTATION", Kind::Index),
                                 optional("SCALE", Kind::Index)};
constexpr Member kInstancing[] = {required_object("attributes", kInstances)};
constexpr Member kNodeLight[] = {required("light", Kind::Index)};
constexpr Member kNodeExtensions[] = {object("EXT_mesh_gpu_instancing", kInstancing),
                                      object("KHR_lights_punctual", kNodeLight)};
constexpr Member kNode[] = {kName,
                            optional("children", Kind::Indices),
                            optional("mesh", Kind::Index),
                            optional("camera", Kind::Index),
                            optional("skin", Kind::Index),
                            optional("weights", Kind::Numbers),
                            numbers("translation", 3),
                            numbers("rotation", 4),
                            numbers("scale", 3),
                            numbers("matrix", 16),
                            object("extensions", kNodeExtensions)};
constexpr Member kScene[] = {kName, optional("nodes", Kind::Indices)};
constexpr Member kSkin[] = {kName, required("joints", Kind::Indices),
                            optional("inverseBindMatrices", Kind::Index)};

constexpr Member kTransform[] = {numbers("offset", 2), numbers("scale", 2),
                                 optional("rotation", Kind::Number), optional("texCoord", Kind::Index)};
constexpr Member kTextureInfoExtensions[] = {object("KHR_texture_transform", kTransform)};
constexpr Member kTextureInfo[] = {required("index", Kind::Index), optional("texCoord", Kind::Index),
                                   object("extensions", kTextureInfoExtensions)};
constexpr Member kSurface[] = {numbers("baseColorFactor", 4), object("baseColorTexture", kTextureInfo)};
constexpr Member kDiffuse[] = {numbers("diffuseFactor", 4), object("diffuseTexture", kTextureInfo)};
constexpr Member kMaterialExtensions[] = {object("KHR_materials_unlit", {}),
                                          object("KHR_materials_pbrSpecularGlossiness", kDiffuse)};
constexpr Member kMaterial[] = {kName,
                                optional("alphaMode", Kind::Text),
                                optional("alphaCutoff", Kind::NotNegative),
                                optional("doubleSided", Kind::Flag),
                                object("pbrMetallicRoughness", kSurface),
                                object("extensions", kMaterialExtensions)};
constexpr Member kImage[] = {kName, optional("uri", Kind::Text), optional("bufferView", Kind::Index)};
constexpr Member kWebp[] = {optional("source", Kind::Index)};
constexpr Member kTextureExtensions[] = {object("EXT_texture_webp", kWebp)};
constexpr Member kTexture[] = {kName, optional("source", Kind::Index), optional("sampler", Kind::Index),
                               object("extensions", kTextureExtensions)};
constexpr Member kSampler[] = {optional("wrapS", Kind::Index), optional("wrapT", Kind::Index)};

constexpr Member kPointer[] = {optional("pointer", Kind::Text)};
constexpr Member kTargetExtensions[] = {object("KHR_animation_pointer", kPointer)};
constexpr Member kTarget[] = {optional("node", Kind::Index), required("path", Kind::Text),
                              object("extensions", kTargetExtensions)};
constexpr Member kChannel[] = {required("sampler", Kind::Index), required_object("target", kTarget)};
constexpr Member kAnimationSampler[] = {required("input", Kind::Index), required("output", Kind::Index),
                                        optional("interpolation", Kind::Text)};
constexpr Member kAnimation[] = {kName, required_objects("channels", kChannel),
                                 required_objects("samplers", kAnimationSampler)};

constexpr Member kSpot[] = {optional("innerConeAngle", Kind::NotNegative),
                            optional("outerConeAngle", Kind::NotNegative)};
constexpr Member kLight[] = {kName,
                             required("type", Kind::Text),
                             numbers("color", 3),
                             optional("intensity", Kind::NotNegative),
                             optional("range", Kind::Positive),
                             object("spot", kSpot)};
constexpr Member kLights[] = {required_objects("lights", kLight)};
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
                            optional("scene", Kind::Index),
                            objects("cameras", kNamed)};

bool is_whole(const json& value, std::uint64_t least, std::uint64_t most) {
  return value.is_number_unsigned() && value.get<std::uint64_t>() >= least &&
         value.get<std::uint64_t>() <= most;
}

bool is_index(const json& value) {
  return is_whole(value, 0, kMaxIndex);
}

bool is_number(const json& value, double least) {
  return value.is_number() && value.get<double>() >= least && value.get<double>() <= kMaxNumber;
}

template <class Test>
bool is_list_of(const json& value, Test test) {
  return value.is_array() && std::all_of(value.begin(), value.end(), test);
}

bool fits(const json& value, const Member& member) {
  switch (member.kind) {
    case Kind::Index:
      return is_index(value);
    case Kind::Length:
      return is_whole(value, 1, kMaxIndex);
    case Kind::Size:
      return is_whole(value, 0, kMaxSize);
    case Kind::LargeLength:
      return is_whole(value, 1, kMaxSize);
    case Kind::Number:
      return is_number(value, -kMaxNumber);
    case Kind::NotNegative:
      return is_number(value, 0.0);
    case Kind::Positive:
      return is_number(value, std::numeric_limits<float>::min());
    case Kind::Flag:
      return value.is_boolean();
    case Kind::Text:
      return value.is_string();
    case Kind::Texts:
      return is_list_of(value, [](const json& v) { return v.is_string(); });
    case Kind::Indices:
      return is_list_of(value, is_index);
    case Kind::Numbers:
      return (member.count == 0 || value.size() == member.count) &&
             is_list_of(value, [](const json& v) { return is_number(v, -kMaxNumber); });
    case Kind::IndexMap:
      return value.is_object() && std::all_of(value.begin(), value.end(), is_index);
    case Kind::Object:
      return value.is_object();
    case Kind::Objects:
      return is_list_of(value, [](const json& v) { return v.is_object(); });
  }
  return false;
}

std::string whole_number(std::uint64_t least, std::uint64_t most) {
  return "a whole number from " + std::to_string(least) + " to " + std::to_string(most);
}

std::string expected(const Member& member) {
  switch (member.kind) {
    case Kind::Index:
      return whole_number(0, kMaxIndex);
    case Kind::Length:
      return whole_number(1, kMaxIndex);
    case Kind::Size:
      return whole_number(0, kMaxSize);
    case Kind::LargeLength:
      return whole_number(1, kMaxSize);
    case Kind::Number:
      return "a number within +-1e30";
    case Kind::NotNegative:
      return "a number from 0 to 1e30";
    case Kind::Positive:
      return "a number above 0, up to 1e30";
    case Kind::Flag:
      return "true or false";
    case Kind::Text:
      return "a text";
    case Kind::Texts:
      return "a list of texts";
    case Kind::Indices:
      return "a list of indices";
    case Kind::Numbers:
      return "a list of " + (member.count ? std::to_string(member.count) + " " : "") +
             "numbers within +-1e30";
    case Kind::IndexMap:
      return "an object whose values are indices";
    case Kind::Object:
      return "an object";
    case Kind::Objects:
      return "a list of objects";
  }
  return "";
}

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
    if (!fits(*found, member)) return malformed(here.text() + " should be " + expected(member));
    if (member.kind == Kind::Object)
      if (auto checked = check_object(*found, member.inner, here); !checked) return checked;
    if (member.kind != Kind::Objects) continue;
    for (std::size_t i = 0; i < found->size(); ++i)
      if (auto checked = check_object((*found)[i], member.inner, {&here, {}, i}); !checked) return checked;
  }
  return {};
}

bool is_fraction(Kind kind) {
  return kind == Kind::Number || kind == Kind::NotNegative || kind == Kind::Positive;
}

/// Also makes numbers that may be fractions floating-point numbers: tinygltf stores whole ones of extensions
/// in 32 bits.
void remove_others(json& object, std::span<const Member> members) {
  for (auto item = object.begin(); item != object.end();) {
    const auto known = std::ranges::find(members, std::string_view(item.key()), &Member::name);
    if (known == members.end()) {
      item = object.erase(item);
      continue;
    }
    if (is_fraction(known->kind)) *item = item->get<double>();
    if (known->kind == Kind::Numbers)
      for (json& number : *item) number = number.get<double>();
    if (known->kind == Kind::Object) remove_others(*item, known->inner);
    if (known->kind == Kind::Objects)
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
