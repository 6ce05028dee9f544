/// The table of the JSON members that the loader reads, with the type and the range of each by the
/// specification. tinygltf accepts wrong types and stores what nobody reads, so the table comes first.

#include <limits>
#include <nlohmann/json.hpp>
#include <span>

#include "stereo/gltf/gltf_extensions.h"
#include "stereo/gltf/gltf_model.h"

namespace farshade::gltf {
namespace {

using nlohmann::json;

constexpr std::uint64_t kMaxSize = (std::uint64_t{1} << 53) - 1;  // a double holds it exactly
constexpr double kMaxNumber = 1e30;                               // a float holds it, a double its products

template <std::uint64_t least, std::uint64_t most>
bool is_whole(const json& value) {
  return value.is_number_unsigned() && value.get<std::uint64_t>() >= least &&
         value.get<std::uint64_t>() <= most;
}
constexpr auto is_index = is_whole<0, kMaxIndex>;
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
constexpr Type kLength{is_whole<1, kMaxIndex>, "a whole number from 1 to 2147483647"};
constexpr Type kSize{is_whole<0, kMaxSize>, "a whole number from 0 to 9007199254740991"};
constexpr Type kLargeLength{is_whole<1, kMaxSize>, "a whole number from 1 to 9007199254740991"};
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
using enum Need;

struct Member {
  std::string_view name;
  const Type& type;
  Need need = Optional;
  std::span<const Member> inner{};    ///< of kObject and kObjects
  std::string_view otherwise = "{}";  ///< of kObjects: instead of an object that means nothing
};

constexpr Member kNamed[] = {{"name", kText}};
constexpr Member kAsset[] = {{"version", kText}, {"minVersion", kText}};

constexpr Member kFallback[] = {{"fallback", kFlag}};
constexpr Member kBufferExtensions[] = {{"EXT_meshopt_compression", kObject, Optional, kFallback},
                                        {"KHR_meshopt_compression", kObject, Optional, kFallback}};
constexpr Member kBuffer[] = {{"byteLength", kLargeLength, Required},
                              {"uri", kText, Essential},
                              {"extensions", kObject, Optional, kBufferExtensions}};
constexpr Member kMeshopt[] = {{"buffer", kIndex, Required},      {"byteOffset", kIndex, Essential},
                               {"byteLength", kLength, Required}, {"byteStride", kLength, Required},
                               {"count", kLength, Required},      {"mode", kText, Required},
                               {"filter", kText, Essential}};
constexpr Member kViewExtensions[] = {{"EXT_meshopt_compression", kObject, Essential, kMeshopt},
                                      {"KHR_meshopt_compression", kObject, Essential, kMeshopt}};
constexpr Member kBufferView[] = {{"buffer", kIndex, Required},
                                  {"byteOffset", kSize, Essential},
                                  {"byteLength", kLargeLength, Required},
                                  {"byteStride", kSize, Essential},
                                  {"extensions", kObject, Essential, kViewExtensions}};

constexpr Member kSparseIndices[] = {
    {"bufferView", kIndex, Required}, {"byteOffset", kIndex, Essential}, {"componentType", kIndex, Required}};
constexpr Member kSparseValues[] = {{"bufferView", kIndex, Required}, {"byteOffset", kIndex, Essential}};
constexpr Member kSparse[] = {{"count", kIndex, Required},
                              {"indices", kObject, Required, kSparseIndices},
                              {"values", kObject, Required, kSparseValues}};
constexpr Member kAccessor[] = {{"bufferView", kIndex, Essential},       {"byteOffset", kSize, Essential},
                                {"componentType", kComponent, Required}, {"normalized", kFlag, Essential},
                                {"count", kLargeLength, Required},       {"type", kElement, Required},
                                {"sparse", kObject, Essential, kSparse}};

constexpr Member kDraco[] = {{"bufferView", kIndex, Required}, {"attributes", kIndexMap, Required}};
constexpr Member kMapping[] = {{"variants", kIndexSet}, {"material", kIndex, Required}};
constexpr Member kMappings[] = {{"mappings", kObjects, Optional, kMapping, R"({"material":0})"}};
constexpr Member kPrimitiveExtensions[] = {{"KHR_draco_mesh_compression", kObject, Essential, kDraco},
                                           {"KHR_materials_variants", kObject, Optional, kMappings}};
constexpr Member kMorphTarget[] = {{"POSITION", kIndex}, {"NORMAL", kIndex}};
constexpr Member kPrimitive[] = {{"attributes", kIndexMap, Required},
                                 {"indices", kIndex, Essential},
                                 {"material", kIndex},
                                 {"mode", kIndex, Essential},
                                 {"targets", kObjects, Optional, kMorphTarget},
                                 {"extensions", kObject, Essential, kPrimitiveExtensions}};
constexpr Member kMesh[] = {{"name", kText},
                            {"primitives", kObjects, Required, kPrimitive, R"({"attributes":{}})"},
                            {"weights", kNumbers}};

constexpr Member kInstances[] = {
    {"TRANSLATION", kIndex, Essential}, {"ROTATION", kIndex, Essential}, {"SCALE", kIndex, Essential}};
constexpr Member kInstancing[] = {{"attributes", kObject, Required, kInstances}};
constexpr Member kNodeLight[] = {{"light", kIndex, Required}};
constexpr Member kVisibility[] = {{"visible", kFlag}};
constexpr Member kNodeExtensions[] = {{"EXT_mesh_gpu_instancing", kObject, Optional, kInstancing},
                                      {"KHR_lights_punctual", kObject, Optional, kNodeLight},
                                      {"KHR_node_visibility", kObject, Optional, kVisibility}};
constexpr Member kNode[] = {{"name", kText},
                            {"children", kIndexSet},
                            {"mesh", kIndex},
                            {"camera", kIndex},
                            {"skin", kIndex},
                            {"weights", kNumbers},
                            {"translation", kVector3},
                            {"rotation", kVector4},
                            {"scale", kVector3},
                            {"matrix", kMatrix4},
                            {"extensions", kObject, Optional, kNodeExtensions}};
constexpr Member kScene[] = {{"name", kText}, {"nodes", kIndexSet}};
constexpr Member kSkin[] = {
    {"name", kText}, {"joints", kJoints, Required}, {"inverseBindMatrices", kIndex, Essential}};

constexpr Member kTransform[] = {
    {"offset", kVector2}, {"scale", kVector2}, {"rotation", kNumber}, {"texCoord", kIndex}};
constexpr Member kTextureInfoExtensions[] = {{"KHR_texture_transform", kObject, Optional, kTransform}};
constexpr Member kTextureInfo[] = {{"index", kIndex, Required},
                                   {"texCoord", kIndex},
                                   {"extensions", kObject, Optional, kTextureInfoExtensions}};
constexpr Member kSurface[] = {{"baseColorFactor", kVector4},
                               {"baseColorTexture", kObject, Optional, kTextureInfo}};
constexpr Member kDiffuse[] = {{"diffuseFactor", kVector4},
                               {"diffuseTexture", kObject, Optional, kTextureInfo}};
constexpr Member kTransmission[] = {{"transmissionFactor", kNotNegative}};
constexpr Member kMaterialExtensions[] = {
    {"KHR_materials_unlit", kObject, Optional, {}},
    {"KHR_materials_transmission", kObject, Optional, kTransmission},
    {"KHR_materials_pbrSpecularGlossiness", kObject, Optional, kDiffuse}};
constexpr Member kMaterial[] = {{"name", kText},
                                {"alphaMode", kText},
                                {"alphaCutoff", kNotNegative},
                                {"emissiveFactor", kVector3},
                                {"doubleSided", kFlag},
                                {"pbrMetallicRoughness", kObject, Optional, kSurface},
                                {"extensions", kObject, Optional, kMaterialExtensions}};
constexpr Member kImage[] = {{"name", kText}, {"uri", kText}, {"bufferView", kIndex}};
constexpr Member kWebp[] = {{"source", kIndex}};
constexpr Member kTextureExtensions[] = {{"EXT_texture_webp", kObject, Optional, kWebp}};
constexpr Member kTexture[] = {{"name", kText},
                               {"source", kIndex},
                               {"sampler", kIndex},
                               {"extensions", kObject, Optional, kTextureExtensions}};
constexpr Member kSampler[] = {{"wrapS", kIndex}, {"wrapT", kIndex}};

constexpr Member kPointer[] = {{"pointer", kText}};
constexpr Member kTargetExtensions[] = {{"KHR_animation_pointer", kObject, Optional, kPointer}};
constexpr Member kTarget[] = {
    {"node", kIndex}, {"path", kText, Required}, {"extensions", kObject, Optional, kTargetExtensions}};
constexpr Member kChannel[] = {{"sampler", kIndex, Required}, {"target", kObject, Required, kTarget}};
constexpr Member kAnimationSampler[] = {
    {"input", kIndex, Required}, {"output", kIndex, Required}, {"interpolation", kText, Essential}};
constexpr Member kAnimation[] = {
    {"name", kText},
    {"channels", kObjects, Required, kChannel, R"({"sampler":0,"target":{"path":""}})"},
    {"samplers", kObjects, Required, kAnimationSampler, R"({"input":2147483647,"output":2147483647})"}};

constexpr Member kSpot[] = {{"innerConeAngle", kNotNegative}, {"outerConeAngle", kNotNegative}};
constexpr Member kLight[] = {{"name", kText},      {"type", kText, Required},
                             {"color", kVector3},  {"intensity", kNotNegative},
                             {"range", kPositive}, {"spot", kObject, Optional, kSpot}};
constexpr Member kLights[] = {{"lights", kObjects, Required, kLight, R"({"type":""})"}};
constexpr Member kVariants[] = {{"variants", kObjects, Optional, kNamed}};
constexpr Member kRootExtensions[] = {{"KHR_lights_punctual", kObject, Optional, kLights},
                                      {"KHR_materials_variants", kObject, Optional, kVariants}};
constexpr Member kRoot[] = {
    {"asset", kObject, Optional, kAsset},
    {"extensionsUsed", kTexts},
    {"extensionsRequired", kTexts},
    {"buffers", kObjects, Optional, kBuffer, R"({"name":"","byteLength":1})"},
    {"bufferViews", kObjects, Optional, kBufferView, R"({"name":"","buffer":0,"byteLength":1})"},
    {"accessors", kObjects, Optional, kAccessor,
     R"({"name":"","componentType":5126,"type":"SCALAR","count":1})"},
    {"samplers", kObjects, Optional, kSampler},
    {"textures", kObjects, Optional, kTexture},
    {"images", kObjects, Optional, kImage},
    {"materials", kObjects, Optional, kMaterial},
    {"meshes", kObjects, Optional, kMesh, R"({"primitives":[]})"},
    {"nodes", kObjects, Optional, kNode},
    {"skins", kObjects, Optional, kSkin, R"({"joints":[]})"},
    {"extensions", kObject, Optional, kRootExtensions},
    {"animations", kObjects, Optional, kAnimation, R"({"channels":[],"samplers":[]})"},
    {"scenes", kObjects, Optional, kScene},
    {"scene", kIndex},
    {"cameras", kObjects, Optional, kNamed}};

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
  if (!of.type.fits(value)) return malformed(place.text() + " should be " + of.type.words);
  make_fractions(of.type, value);
  if (of.name == "name") cut(value.get_ref<std::string&>());
  if (&of.type == &kObjects) keep_each(value, of, place, repairs);
  const auto is_bad = [](const json& one) { return !is_index(one); };
  if (&of.type == &kIndexSet && std::erase_if(value.get_ref<json::array_t&>(), is_bad) > 0)
    repairs.add(kIgnored, place.text() + ": each should be " + kIndex.words);
  if (&of.type == &kIndexMap)
    for (auto entry = value.begin(); entry != value.end();) {
      const std::string& key = entry.key();
      if (is_bad(*entry))
        repairs.add(kIgnored, place.text() + "." + printable(key) + " should be " + kIndex.words);
      // tinygltf ends names at a zero byte, so "POSITION\0" would be POSITION.
      const bool is_kept = !is_bad(*entry) && key.find('\0') == std::string::npos;
      entry = is_kept ? std::next(entry) : value.erase(entry);
    }
  return &of.type == &kObject ? keep(value, of.inner, place, repairs) : Checked{};
}

/// Keeps the members of an object that are right. Returns the fault of an object that means nothing.
Checked keep(json& object, std::span<const Member> members, const Place& place, Repairs& repairs) {
  for (const Member& member : members)
    if (member.need == Required && !object.contains(member.name))
      return malformed(Place{&place, member.name}.text() + " is missing");
  for (auto item = object.begin(); item != object.end();) {
    const auto known = std::ranges::find(members, std::string_view(item.key()), &Member::name);
    const Checked kept =
        known == members.end() ? Checked() : keep_value(*item, *known, {&place, known->name}, repairs);
    if (!kept && known->need != Optional) return kept;
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
