#include "stereo/scene/gltf_schema.h"

#include <cstdint>
#include <span>

#include "stereo/scene/gltf_json.h"

namespace farshade::gltf {
namespace {

enum class Kind {
  Index,
  Size,
  Length,
  Number,
  NonNegative,
  Positive,
  Boolean,
  String,
  Strings,
  Indices,
  Numbers,
  IndexMap,
  Object,
  Objects
};

constexpr std::uint64_t kMaxIndex = (std::uint64_t{1} << 31) - 1;  // the sum of two indices fits in 32 bits
constexpr std::uint64_t kMaxSize = (std::uint64_t{1} << 53) - 1;   // a double holds every such number exactly
constexpr double kMaxNumber = 1e30;  // fits in a float; products fit in a double

struct Field {
  std::string_view name;
  Kind kind;
  bool required = false;
  std::span<const Field> inner = {};  ///< fields of an Object or of the elements of Objects
  std::size_t length = 0;             ///< number of elements of Numbers; 0 = any
};
constexpr bool kMust = true, kMay = false;

constexpr Field kAsset[] = {{"version", Kind::String, kMust}, {"minVersion", Kind::String}};
constexpr Field kBuffer[] = {{"byteLength", Kind::Length, kMust}, {"uri", Kind::String}};
constexpr Field kBufferView[] = {{"buffer", Kind::Index, kMust},
                                 {"byteOffset", Kind::Size},
                                 {"byteLength", Kind::Length, kMust},
                                 {"byteStride", Kind::Size}};
constexpr Field kSparseIndices[] = {
    {"bufferView", Kind::Index, kMust}, {"byteOffset", Kind::Index}, {"componentType", Kind::Index, kMust}};
constexpr Field kSparseValues[] = {{"bufferView", Kind::Index, kMust}, {"byteOffset", Kind::Index}};
constexpr Field kSparse[] = {{"count", Kind::Index, kMust},
                             {"indices", Kind::Object, kMust, kSparseIndices},
                             {"values", Kind::Object, kMust, kSparseValues}};
constexpr Field kAccessor[] = {
    {"bufferView", Kind::Index},   {"byteOffset", Kind::Size},     {"componentType", Kind::Index, kMust},
    {"normalized", Kind::Boolean}, {"count", Kind::Length, kMust}, {"type", Kind::String, kMust},
    {"min", Kind::Numbers},        {"max", Kind::Numbers},         {"sparse", Kind::Object, kMay, kSparse}};
constexpr Field kPrimitive[] = {{"attributes", Kind::IndexMap, kMust},
                                {"indices", Kind::Index},
                                {"material", Kind::Index},
                                {"mode", Kind::Index}};
constexpr Field kMesh[] = {
    {"name", Kind::String}, {"primitives", Kind::Objects, kMust, kPrimitive}, {"weights", Kind::Numbers}};
constexpr Field kNodeLight[] = {{"light", Kind::Index, kMust}};
constexpr Field kNodeExtensions[] = {{"KHR_lights_punctual", Kind::Object, kMay, kNodeLight}};
constexpr Field kNode[] = {{"name", Kind::String},
                           {"children", Kind::Indices},
                           {"mesh", Kind::Index},
                           {"camera", Kind::Index},
                           {"skin", Kind::Index},
                           {"translation", Kind::Numbers, kMay, {}, 3},
                           {"rotation", Kind::Numbers, kMay, {}, 4},
                           {"scale", Kind::Numbers, kMay, {}, 3},
                           {"matrix", Kind::Numbers, kMay, {}, 16},
                           {"weights", Kind::Numbers},
                           {"extensions", Kind::Object, kMay, kNodeExtensions}};
constexpr Field kScene[] = {{"name", Kind::String}, {"nodes", Kind::Indices}};
constexpr Field kTransform[] = {{"offset", Kind::Numbers, kMay, {}, 2},
                                {"rotation", Kind::Number},
                                {"scale", Kind::Numbers, kMay, {}, 2},
                                {"texCoord", Kind::Index}};
constexpr Field kTextureExtensions[] = {{"KHR_texture_transform", Kind::Object, kMay, kTransform}};
constexpr Field kTextureInfo[] = {{"index", Kind::Index, kMust},
                                  {"texCoord", Kind::Index},
                                  {"extensions", Kind::Object, kMay, kTextureExtensions}};
constexpr Field kPbr[] = {{"baseColorFactor", Kind::Numbers, kMay, {}, 4},
                          {"baseColorTexture", Kind::Object, kMay, kTextureInfo},
                          {"metallicRoughnessTexture", Kind::Object}};
constexpr Field kMaterial[] = {
    {"name", Kind::String},           {"pbrMetallicRoughness", Kind::Object, kMay, kPbr},
    {"alphaMode", Kind::String},      {"alphaCutoff", Kind::NonNegative},
    {"doubleSided", Kind::Boolean},   {"emissiveFactor", Kind::Numbers, kMay, {}, 3},
    {"normalTexture", Kind::Object},  {"occlusionTexture", Kind::Object},
    {"emissiveTexture", Kind::Object}};
constexpr Field kImage[] = {
    {"name", Kind::String}, {"uri", Kind::String}, {"bufferView", Kind::Index}, {"mimeType", Kind::String}};
constexpr Field kTexture[] = {{"name", Kind::String}, {"source", Kind::Index}, {"sampler", Kind::Index}};
constexpr Field kSampler[] = {{"wrapS", Kind::Index}, {"wrapT", Kind::Index}, {"name", Kind::String}};
constexpr Field kTarget[] = {{"node", Kind::Index}, {"path", Kind::String, kMust}};
constexpr Field kChannel[] = {{"sampler", Kind::Index, kMust}, {"target", Kind::Object, kMust, kTarget}};
constexpr Field kAnimationSampler[] = {
    {"input", Kind::Index, kMust}, {"output", Kind::Index, kMust}, {"interpolation", Kind::String}};
constexpr Field kAnimation[] = {{"name", Kind::String},
                                {"channels", Kind::Objects, kMust, kChannel},
                                {"samplers", Kind::Objects, kMust, kAnimationSampler}};
constexpr Field kSkin[] = {{"joints", Kind::Indices, kMust}};
constexpr Field kCamera[] = {{"type", Kind::String, kMust}};
constexpr Field kSpot[] = {{"innerConeAngle", Kind::NonNegative}, {"outerConeAngle", Kind::NonNegative}};
constexpr Field kLight[] = {
    {"name", Kind::String},           {"type", Kind::String, kMust}, {"color", Kind::Numbers, kMay, {}, 3},
    {"intensity", Kind::NonNegative}, {"range", Kind::Positive},     {"spot", Kind::Object, kMay, kSpot}};
constexpr Field kLights[] = {{"lights", Kind::Objects, kMust, kLight}};
constexpr Field kRootExtensions[] = {{"KHR_lights_punctual", Kind::Object, kMay, kLights}};
constexpr Field kRoot[] = {{"asset", Kind::Object, kMust, kAsset},
                           {"extensionsUsed", Kind::Strings},
                           {"extensionsRequired", Kind::Strings},
                           {"buffers", Kind::Objects, kMay, kBuffer},
                           {"bufferViews", Kind::Objects, kMay, kBufferView},
                           {"accessors", Kind::Objects, kMay, kAccessor},
                           {"meshes", Kind::Objects, kMay, kMesh},
                           {"nodes", Kind::Objects, kMay, kNode},
                           {"scenes", Kind::Objects, kMay, kScene},
                           {"scene", Kind::Index},
                           {"materials", Kind::Objects, kMay, kMaterial},
                           {"images", Kind::Objects, kMay, kImage},
                           {"textures", Kind::Objects, kMay, kTexture},
                           {"samplers", Kind::Objects, kMay, kSampler},
                           {"animations", Kind::Objects, kMay, kAnimation},
                           {"cameras", Kind::Objects, kMay, kCamera},
                           {"skins", Kind::Objects, kMay, kSkin},
                           {"extensions", Kind::Object, kMay, kRootExtensions}};

/// The path of a value in the JSON. It becomes text only for an error message.
struct Place {
  const Place* parent = nullptr;
  std::string_view name = {};
  std::optional<std::size_t> element = {};

  [[nodiscard]] std::string text() const {
    if (!parent) return "";
    if (element) return parent->text() + "[" + std::to_string(*element) + "]";
    const std::string before = parent->text();
    return (before.empty() ? "" : before + ".") + printable(name);
  }
};

bool is_whole(const json& value, std::uint64_t least, std::uint64_t most) {
  return value.is_number_unsigned() && value.get<std::uint64_t>() >= least &&
         value.get<std::uint64_t>() <= most;
}

bool is_number(const json& value, double least) {
  return value.is_number() && value.get<double>() >= least && value.get<double>() <= kMaxNumber;
}

template <class Test>
bool all_of(const json& array, Test test) {
  return array.is_array() && std::all_of(array.begin(), array.end(), test);
}

bool fits(const json& value, const Field& field) {
  const auto is_index = [](const json& v) { return is_whole(v, 0, kMaxIndex); };
  switch (field.kind) {
    case Kind::Index:
      return is_index(value);
    case Kind::Size:
      return is_whole(value, 0, kMaxSize);
    case Kind::Length:
      return is_whole(value, 1, kMaxSize);
    case Kind::Number:
      return is_number(value, -kMaxNumber);
    case Kind::NonNegative:
      return is_number(value, 0.0);
    case Kind::Positive:
      return is_number(value, std::numeric_limits<float>::min());
    case Kind::Boolean:
      return value.is_boolean();
    case Kind::String:
      return value.is_string();
    case Kind::Strings:
      return all_of(value, [](const json& v) { return v.is_string(); });
    case Kind::Indices:
      return all_of(value, is_index);
    case Kind::Numbers:
      return (field.length == 0 || value.size() == field.length) &&
             all_of(value, [](const json& v) { return is_number(v, -kMaxNumber); });
    case Kind::IndexMap:
      return value.is_object() && std::all_of(value.begin(), value.end(), is_index);
    case Kind::Object:
      return value.is_object();
    case Kind::Objects:
      return all_of(value, [](const json& v) { return v.is_object(); });
  }
  return false;
}

std::string wanted(const Field& field) {
  switch (field.kind) {
    case Kind::Index:
      return "a whole number from 0 to " + std::to_string(kMaxIndex);
    case Kind::Size:
      return "a whole number from 0 to " + std::to_string(kMaxSize);
    case Kind::Length:
      return "a whole number from 1 to " + std::to_string(kMaxSize);
    case Kind::Number:
      return "a number within +-1e30";
    case Kind::NonNegative:
      return "a number from 0 to 1e30";
    case Kind::Positive:
      return "a number above 0, up to 1e30";
    case Kind::Boolean:
      return "true or false";
    case Kind::String:
      return "a text";
    case Kind::Strings:
      return "a list of texts";
    case Kind::Indices:
      return "a list of indices";
    case Kind::Numbers:
      return "a list of " + (field.length ? std::to_string(field.length) + " " : "") +
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

Checked check_object(const json& object, std::span<const Field> fields, const Place& place);

Checked check_field(const json& value, const Field& field, const Place& place) {
  if (!fits(value, field)) return malformed(place.text() + " should be " + wanted(field));
  if (field.kind == Kind::Object) return check_object(value, field.inner, place);
  if (field.kind != Kind::Objects) return {};
  for (std::size_t i = 0; i < value.size(); ++i)
    if (auto checked = check_object(value[i], field.inner, Place{&place, {}, i}); !checked) return checked;
  return {};
}

Checked check_object(const json& object, std::span<const Field> fields, const Place& place) {
  for (const Field& field : fields) {
    const Place here{&place, field.name};
    const auto found = object.find(field.name);
    if (found == object.end()) {
      if (field.required) return malformed(here.text() + " is missing");
    } else if (auto checked = check_field(*found, field, here); !checked) {
      return checked;
    }
  }
  return {};
}

template <class Check>
Checked check_list(const json& root, std::string_view name, Check check_item) {
  const auto& list = list_in(root, name);
  for (std::size_t i = 0; i < list.size(); ++i)
    if (Checked checked = check_item(i, list[i]); !checked) return checked;
  return {};
}

/// Only the first buffer of a GLB may be its binary chunk; every other buffer needs a URI.
Checked check_buffers(const json& root, bool has_bin) {
  return check_list(root, "buffers", [&](std::size_t i, const json& buffer) -> Checked {
    if (buffer.contains("uri") || (i == 0 && has_bin)) return {};
    return malformed(label("buffer", i) + " has neither a URI nor a GLB's binary chunk");
  });
}

Checked check_view_strides(const json& root) {
  return check_list(root, "bufferViews", [](std::size_t i, const json& view) -> Checked {
    const auto stride = view.value("byteStride", std::uint64_t{4});
    if (stride >= 4 && stride <= 252 && stride % 4 == 0) return {};
    return malformed(label("buffer view", i) + ": its stride should be a multiple of 4 from 4 to 252");
  });
}

Checked check_accessor_types(const json& root) {
  constexpr std::string_view known[] = {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"};
  return check_list(root, "accessors", [&](std::size_t i, const json& accessor) -> Checked {
    const auto& type = accessor["type"].get_ref<const std::string&>();
    if (std::find(std::begin(known), std::end(known), type) != std::end(known)) return {};
    return malformed(label("accessor", i) + ": unknown type '" + printable(type) + "'");
  });
}

Checked check_images(const json& root) {
  return check_list(root, "images", [](std::size_t i, const json& image) -> Checked {
    if (image.contains("bufferView") != image.contains("uri")) return {};
    return malformed(label("image", i) + " should have either a URI or a buffer view");
  });
}

Checked check_node_transforms(const json& root) {
  return check_list(root, "nodes", [](std::size_t i, const json& node) -> Checked {
    const bool has_parts =
        node.contains("translation") || node.contains("rotation") || node.contains("scale");
    if (!node.contains("matrix") || !has_parts) return {};
    return malformed(label("node", i, text_in(node, "name")) +
                     " has both a matrix and translation, rotation or scale");
  });
}

Checked check_spots(const json& root) {
  return check_list(
      extension_in(root, "KHR_lights_punctual"), "lights", [](std::size_t i, const json& light) -> Checked {
        if (light["type"] != "spot" || light.contains("spot")) return {};
        return malformed(label("light", i, text_in(light, "name")) + " is a spot without a cone");
      });
}

Checked check_version(const json& asset) {
  const std::string version = text_in(asset, "version"), least = text_in(asset, "minVersion", "2.0");
  if (version.starts_with("2.") && least == "2.0") return {};
  return fail(Fault::Unsupported,
              "glTF version " + printable(least == "2.0" ? version : least) + ", only 2.0 is read");
}

}  // namespace

Expected<json> parse_json(std::string_view text, bool has_bin) {
  json root;
  try {
    root = json::parse(text);
  } catch (const json::exception& refusal) {
    const std::string_view what = refusal.what();
    const auto after_tag = what.find("] ");
    return malformed("JSON: " + printable(after_tag == what.npos ? what : what.substr(after_tag + 2)));
  }
  if (!root.is_object()) return malformed("JSON: the file is not an object");
  const Checked checked = check_object(root, kRoot, Place{})
                              .and_then([&] { return check_version(root["asset"]); })
                              .and_then([&] { return check_buffers(root, has_bin); })
                              .and_then([&] { return check_view_strides(root); })
                              .and_then([&] { return check_accessor_types(root); })
                              .and_then([&] { return check_images(root); })
                              .and_then([&] { return check_node_transforms(root); })
                              .and_then([&] { return check_spots(root); });
  if (!checked) return tl::unexpected(checked.error());
  return root;
}

}  // namespace farshade::gltf
