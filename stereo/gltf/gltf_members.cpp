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
template <const auto& list>
bool is_one_of(const json& value) {
  return !value.is_number_float() &&
         std::ranges::any_of(list, [&](const auto& one) { return value == json(one); });
}
bool is_at_least(const json& value, double least) {
  return value.is_number() && value.get<double>() >= least;
}
bool is_number(const json& value) {
  return is_at_least(value, -kMaxNumber) && value.get<double>() <= kMaxNumber;
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
constexpr Type kNotNegative{[](const json& value) { return is_at_least(value, 0); }, "a number from 0 on"};
constexpr Type kPositive{
    [](const json& value) { return is_at_least(value, double{std::numeric_limits<float>::min()}); },
    "a number above 0"};
constexpr Type kFlag{[](const json& value) { return value.is_boolean(); }, "true or false"};
constexpr Type kText{is_text, "a text"}, kTexts{is_list_of<is_text>, "a list of texts"};
constexpr Type kIndexSet{[](const json& value) { return value.is_array(); }, "a list of indices"};
constexpr Type kJoints{[](const json& value) { return !value.empty() && is_list_of<is_index>(value); },
                       "a list of at least one index"};
constexpr Type kNumbers{is_list_of<is_number>, "a list of numbers within +-1e30"};
constexpr Type kVector2{is_vector<2>, "a list of 2 numbers within +-1e30"},
    kVector3{is_vector<3>, "a list of 3 numbers within +-1e30"},
    kVector4{is_vector<4>, "a list of 4 numbers within +-1e30"},
    kMatrix4{is_vector<16>, "a list of 16 numbers within +-1e30"};
constexpr int kComponents[] = {5120, 5121, 5122, 5123, 5125, 5126};
constexpr Type kComponent{is_one_of<kComponents>, "5120, 5121, 5122, 5123, 5125 or 5126"};
constexpr const char* kTypes[] = {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"};
constexpr Type kElement{is_one_of<kTypes>, "SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4"};
constexpr Type kObject{[](const json&value) { return value.is_object(); }, "an object"},
    kIndexMap{kObject.fits, kObject.words};
constexpr Type kObjects{[](const json& value) { return value.is_array(); }, "a list of objects"};

/// What becomes of an object whose member has a wrong value: without an optional member, it has the default.
/// Without another one it means nothing. A required member must also be there.
enum class Need { Optional, Essential, Required };

struct Member {
  std::string_view name;
  const Type* type;
  Need need = Need::Optional;
  std::span<const Member> inner{};    ///< of kObject and kObjects
  std::string_view otherwise = "{}";  ///< of kObjects: instead of an object that means nothing
};

constexpr Member optional(std::string_view name, const Type& type) {
  return {name, &type};
}
constexpr Member essential(std::string_view name, const Type& type) {
  return {name, &type, Need::Essential};
}
constexpr Member required(std::string_view name, const Type& type) {
  return {name, &type, Need::Required};
}
constexpr Member object(std::string_view name, std::span<const Member> inner, Need need = Need::Optional) {
  return {name, &kObject, need, inner};
}
constexpr Member objects(std::string_view name, std::span<const Member> inner,
                         std::string_view otherwise = "{}", Need need = Need::Optional) {
  return {name, &kObjects, need, inner, otherwise};
}
constexpr Member kName = optional("name", kText);
constexpr Member kNamed[] = {kName};
constexpr Member kAsset[] = {optional("version", kText), optional("minVersion", kText)};

constexpr Member kFallback[] = {optional("fallback", kFlag)};
constexpr Member kBufferExtensions[] = {object("EXT_meshopt_compression", kFallback),
                                        object("KHR_meshopt_compression", kFallback)};
constexpr Member kBuffer[] = {required("byteLength", kLargeLength), essential("uri", kText),
                              object("extensions", kBufferExtensions)};
constexpr Member kMeshopt[] = {required("buffer", kIndex),      essential("byteOffset", kIndex),
                               required("byteLength", kLength), required("byteStride", kLength),
                               required("count", kLength),      required("mode", kText),
                               essential("filter", kText)};
constexpr Member kViewExtensions[] = {object("EXT_meshopt_compression", kMeshopt, Need::Essential),
                                      object("KHR_meshopt_compression", kMeshopt, Need::Essential)};
constexpr Member kBufferView[] = {required("buffer", kIndex), essential("byteOffset", kSize),
                                  required("byteLength", kLargeLength), essential("byteStride", kSize),
                                  object("extensions", kViewExtensions, Need::Essential)};

constexpr Member kSparseIndices[] = {required("bufferView", kIndex), essential("byteOffset", kIndex),
                                     required("componentType", kIndex)};
constexpr Member kSparseValues[] = {required("bufferView", kIndex), essential("byteOffset", kIndex)};
constexpr Member kSparse[] = {required("count", kIndex), object("indices", kSparseIndices, Need::Required),
                              object("values", kSparseValues, Need::Required)};
constexpr Member kAccessor[] = {essential("bufferView", kIndex),           essential("byteOffset", kSize),
                                required("componentType", kComponent),     essential("normalized", kFlag),
                                required("count", kLargeLength),           required("type", kElement),
                                object("sparse", kSparse, Need::Essential)};

constexpr Member kDraco[] = {required("bufferView", kIndex), required("attributes", kIndexMap)};
constexpr Member kMapping[] = {optional("variants", kIndexSet), required("material", kIndex)};
constexpr Member kMappings[] = {objects("mappings", kMapping, R"({"material":0})")};
constexpr Member kPrimitiveExtensions[] = {object("KHR_draco_mesh_compression", kDraco, Need::Essential),
                                           object("KHR_materials_variants", kMappings)};
constexpr Member kMorphTarget[] = {optional("POSITION", kIndex), optional("NORMAL", kIndex)};
constexpr Member kPrimitive[] = {
    required("attributes", kIndexMap), essential("indices", kIndex),
    optional("material", kIndex),      essential("mode", kIndex),
    objects("targets", kMorphTarget),  object("extensions", kPrimitiveExtensions, Need::Essential)};
constexpr Member kMesh[] = {kName, objects("primitives", kPrimitive, R"({"attributes":{}})", Need::Required),
                            optional("weights", kNumbers)};

constexpr Member kInstances[] = {essential("TRANSLATION", kIndex), essential("ROTATION", kIndex),
                                 essential("SCALE", kIndex)};
constexpr Member kInstancing[] = {object("attributes", kInstances, Need::Required)};
constexpr Member kNodeLight[] = {required("light", kIndex)};
constexpr Member kVisibility[] = {optional("visible", kFlag)};
constexpr Member kNodeExtensions[] = {object("EXT_mesh_gpu_instancing", kInstancing),
                                      object("KHR_lights_punctual", kNodeLight),
                                      object("KHR_node_visibility", kVisibility)};
constexpr Member kNode[] = {kName,
                            optional("children", kIndexSet),
                            optional("mesh", kIndex),
                            optional("camera", kIndex),
                            optional("skin", kIndex),
                            optional("weights", kNumbers),
                            optional("translation", kVector3),
                            optional("rotation", kVector4),
                            optional("scale", kVector3),
                            optional("matrix", kMatrix4),
                            object("extensions", kNodeExtensions)};
constexpr Member kScene[] = {kName, optional("nodes", kIndexSet)};
constexpr Member kSkin[] = {kName, required("joints", kJoints), essential("inverseBindMatrices", kIndex)};

constexpr Member kTransform[] = {optional("offset", kVector2), optional("scale", kVector2),
                                 optional("rotation", kNumber), optional("texCoord", kIndex)};
constexpr Member kTextureInfoExtensions[] = {object("KHR_texture_transform", kTransform)};
constexpr Member kTextureInfo[] = {required("index", kIndex), optional("texCoord", kIndex),
                                   object("extensions", kTextureInfoExtensions)};
constexpr Member kSurface[] = {optional("baseColorFactor", kVector4),
                               object("baseColorTexture", kTextureInfo)};
constexpr Member kDiffuse[] = {optional("diffuseFactor", kVector4), object("diffuseTexture", kTextureInfo)};
constexpr Member kTransmission[] = {optional("transmissionFactor", kNotNegative)};
constexpr Member kMaterialExtensions[] = {object("KHR_materials_unlit", {}),
                                          object("KHR_materials_transmission", kTransmission),
                                          object("KHR_materials_pbrSpecularGlossiness", kDiffuse)};
constexpr Member kMaterial[] = {kName,
                                optional("alphaMode", kText),
                                optional("alphaCutoff", kNotNegative),
                                optional("emissiveFactor", kVector3),
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
                                        essential("interpolation", kText)};
constexpr Member kAnimation[] = {
    kName, objects("channels", kChannel, R"({"sampler":0,"target":{"path":""}})", Need::Required),
    objects("samplers", kAnimationSampler, R"({"input":2147483647,"output":2147483647})", Need::Required)};

constexpr Member kSpot[] = {optional("innerConeAngle", kNotNegative),
                            optional("outerConeAngle", kNotNegative)};
constexpr Member kLight[] = {kName,
                             required("type", kText),
                             optional("color", kVector3),
                             optional("intensity", kNotNegative),
                             optional("range", kPositive),
                             object("spot", kSpot)};
constexpr Member kLights[] = {objects("lights", kLight, R"({"type":""})", Need::Required)};
constexpr Member kVariants[] = {objects("variants", kNamed)};
constexpr Member kRootExtensions[] = {object("KHR_lights_punctual", kLights),
                                      object("KHR_materials_variants", kVariants)};
constexpr Member kRoot[] = {
    object("asset", kAsset),
    optional("extensionsUsed", kTexts),
    optional("extensionsRequired", kTexts),
    objects("buffers", kBuffer, R"({"name":"","byteLength":1})"),
    objects("bufferViews", kBufferView, R"({"name":"","buffer":0,"byteLength":1})"),
    objects("accessors", kAccessor, R"({"name":"","componentType":5126,"type":"SCALAR","count":1})"),
    objects("samplers", kSampler),
    objects("textures", kTexture),
    objects("images", kImage),
    objects("materials", kMaterial),
    objects("meshes", kMesh, R"({"primitives":[]})"),
    objects("nodes", kNode),
    objects("skins", kSkin, R"({"joints":[]})"),
    object("extensions", kRootExtensions),
    objects("animations", kAnimation, R"({"channels":[],"samplers":[]})"),
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

/// tinygltf stores whole numbers of extensions in 32 bits, so numbers that may be fractions become
/// floating-point numbers.
void make_fractions(const Type& type, json& value) {
  if (&type == &kNumber || &type == &kNotNegative || &type == &kPositive) value = value.get<double>();
  if (value.is_array() && &type != &kJoints && &type != &kIndexSet)
    for (json& element : value)
      if (element.is_number()) element = element.get<double>();
}

constexpr const char* kIgnored = "it is ignored";

Checked keep(json& object, std::span<const Member> members, const Place& place, Repairs& repairs);

/// Keeps the members of each object of a list.
void keep_each(json& list, const Member& of, const Place& place, Repairs& repairs) {
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Place here{&place, {}, i};
    const Checked kept = list[i].is_object() ? keep(list[i], of.inner, here, repairs)
                                             : Checked(malformed(here.text() + " should be an object"));
    if (kept) continue;
    list[i] = json::parse(of.otherwise);
    if (list[i].value("name", "x").empty())
      list[i]["name"] = kept.error().what;
    else
      repairs.add(kIgnored, kept.error());
  }
}

/// A name is copied to everything that is made of its object.
void cut(std::string& name) {
  std::size_t end = 256;
  if (name.size() <= end) return;
  while ((static_cast<unsigned char>(name[end]) & 0xc0) == 0x80) --end;  // within a character
  name.resize(end);
}

/// Keeps the parts of a value that are right. Returns the fault of a value of which nothing is.
Checked keep_value(json& value, const Member& of, const Place& place, Repairs& repairs) {
  if (!of.type->fits(value)) return malformed(place.text() + " should be " + of.type->words);
  make_fractions(*of.type, value);
  if (of.name == "name") cut(value.get_ref<std::string&>());
  if (of.type == &kObjects) keep_each(value, of, place, repairs);
  const auto is_bad = [](const json& one) { return !is_index(one); };
  if (of.type == &kIndexSet && std::erase_if(value.get_ref<json::array_t&>(), is_bad) > 0)
    repairs.add(kIgnored, place.text() + ": each should be " + kIndex.words);
  if (of.type == &kIndexMap)
    for (auto entry = value.begin(); entry != value.end();) {
      const std::string& key = entry.key();
      if (is_bad(*entry))
        repairs.add(kIgnored, place.text() + "." + printable(key) + " should be " + kIndex.words);
      // tinygltf ends names at a zero byte, so "POSITION\0" would be POSITION.
      const bool is_kept = !is_bad(*entry) && key.find('\0') == std::string::npos;
      entry = is_kept ? std::next(entry) : value.erase(entry);
    }
  return of.type == &kObject ? keep(value, of.inner, place, repairs) : Checked{};
}

/// Keeps the members of an object that are right. Returns the fault of an object that means nothing.
Checked keep(json& object, std::span<const Member> members, const Place& place, Repairs& repairs) {
  for (const Member& member : members)
    if (member.need == Need::Required && !object.contains(member.name))
      return malformed(Place{&place, member.name}.text() + " is missing");
  for (auto item = object.begin(); item != object.end();) {
    const auto known = std::ranges::find(members, std::string_view(item.key()), &Member::name);
    const Checked kept =
        known == members.end() ? Checked() : keep_value(*item, *known, {&place, known->name}, repairs);
    if (!kept && known->need != Need::Optional) return kept;
    if (!kept) repairs.add(kIgnored, kept.error());
    item = kept && known != members.end() ? std::next(item) : object.erase(item);
  }
  return {};
}

}  // namespace

void keep_members(json& root, Repairs& repairs) {
  static_cast<void>(keep(root, kRoot, {}, repairs));  // no member of the root is required
}

}  // namespace farshade::gltf
