#include "tests/unit/gltf/gltf_builder.h"

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <memory>
#include <span>

#include "tests/unit/image/image_files.h"

namespace farshade {
namespace {

using nlohmann::json;

template <class T>
void append(std::vector<std::byte>& to, const T* data, std::size_t count) {
  const auto* bytes = reinterpret_cast<const std::byte*>(data);
  to.insert(to.end(), bytes, bytes + count * sizeof(T));
}

void append_u32(std::vector<std::byte>& to, std::size_t value) {
  for (int i = 0; i < 4; ++i) to.push_back(static_cast<std::byte>(value >> 8 * i & 0xFF));
}

/// Appends to the list `name`. Makes the list if it is missing.
std::uint32_t push(json& object, const char* name, const json& value) {
  object[name].push_back(value);
  return static_cast<std::uint32_t>(object[name].size() - 1);
}

std::string base64(const std::vector<std::byte>& bytes) {
  constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k > bytes.size() ? '=' : digits[group >> (18 - 6 * k) & 63];
  }
  return text;
}

}  // namespace

GltfBuilder::GltfBuilder() : json({{"asset", {{"version", "2.0"}}}, {"scene", 0}}) {
  json["scenes"] = json::array({{{"nodes", json::array()}}});
}

std::uint32_t GltfBuilder::view_of_bytes(const void* data, std::size_t size) {
  bytes_.resize((bytes_.size() + 3) / 4 * 4);
  const std::size_t offset = bytes_.size();
  append(bytes_, static_cast<const std::byte*>(data), size);
  json["buffers"] = json::array({{{"byteLength", bytes_.size()}}});
  return push(json, "bufferViews", {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}});
}

std::uint32_t GltfBuilder::accessor(std::uint32_t view, int component, const std::string& type,
                                    std::size_t count, const nlohmann::json& more) {
  nlohmann::json accessor{
      {"bufferView", view}, {"componentType", component}, {"type", type}, {"count", count}};
  if (!more.is_null()) accessor.update(more);
  return push(json, "accessors", accessor);
}

std::uint32_t GltfBuilder::positions(const std::vector<glm::vec3>& points) {
  return accessor(view(points), 5126, "VEC3", points.size());
}

std::uint32_t GltfBuilder::mesh(const nlohmann::json& primitive) {
  const auto number = push(json, "meshes", {{"name", "chair"}, {"primitives", {primitive}}});
  node({{"name", "seat"}, {"mesh", number}});
  return number;
}

std::uint32_t GltfBuilder::node(const nlohmann::json& node) {
  const auto number = push(json, "nodes", node);
  json["scenes"][0]["nodes"].push_back(number);
  return number;
}

nlohmann::json GltfBuilder::light(const nlohmann::json& light) {
  const auto number = push(json["extensions"]["KHR_lights_punctual"], "lights", light);
  return {{"KHR_lights_punctual", {{"light", number}}}};
}

std::vector<std::byte> GltfBuilder::glb() const {
  std::string text = json.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::vector<std::byte> bin = bytes_;
  bin.resize((bin.size() + 3) / 4 * 4);
  std::vector<std::byte> file = bytes_of_text("glTF");
  append_u32(file, 2);
  append_u32(file, 20 + text.size() + (bin.empty() ? 0 : 8 + bin.size()));
  append_u32(file, text.size());
  append(file, "JSON", 4);
  append(file, text.data(), text.size());
  if (bin.empty()) return file;
  append_u32(file, bin.size());
  append(file, "BIN\0", 4);
  append(file, bin.data(), bin.size());
  return file;
}

std::vector<std::byte> GltfBuilder::gltf() const {
  auto text = json;
  text["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64(bytes_);
  return bytes_of_text(text.dump());
}

GltfBuilder triangle_file() {
  GltfBuilder file;
  const auto positions = file.positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  const auto indices = file.accessor(file.view<std::uint16_t>({0, 1, 2}), 5123, "SCALAR", 3);
  file.mesh({{"attributes", {{"POSITION", positions}}}, {"indices", indices}});
  return file;
}

GltfBuilder rich_file() {
  GltfBuilder file;
  const auto positions = file.positions({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  file.json["accessors"][positions]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", file.view<std::uint8_t>({2})}, {"componentType", 5121}}},
      {"values", {{"bufferView", file.view<glm::vec3>({{1, 1, 0.5f}})}}}};
  const auto normals = file.accessor(file.view(std::vector<glm::vec3>(4, {0, 0, 1})), 5126, "VEC3", 4);
  const auto uvs = file.accessor(file.view<glm::vec2>({{0, 0}, {1, 0}, {1, 1}, {0, 1}}), 5126, "VEC2", 4);
  const auto colors = file.accessor(file.view(std::vector<glm::u8vec4>(4, {255, 128, 0, 255})), 5121, "VEC4",
                                    4, {{"normalized", true}});
  const auto indices = file.accessor(file.view<std::uint16_t>({0, 1, 2, 0, 2, 3}), 5123, "SCALAR", 6);
  file.json["images"] = {{{"bufferView", file.view(make_noise_png({4, 4}))}, {"mimeType", "image/png"}}};
  file.json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}}};
  file.json["textures"] = {{{"source", 0}, {"sampler", 0}}};
  file.json["materials"] = {
      {{"name", "cloth"},
       {"alphaMode", "MASK"},
       {"pbrMetallicRoughness",
        {{"baseColorTexture",
          {{"index", 0}, {"extensions", {{"KHR_texture_transform", {{"offset", {0.5, 0.25}}}}}}}}}}}};
  file.mesh({{"attributes",
              {{"POSITION", positions}, {"NORMAL", normals}, {"TEXCOORD_0", uvs}, {"COLOR_0", colors}}},
             {"indices", indices},
             {"material", 0}});
  file.json["nodes"][0]["children"] = {1};
  file.json["nodes"].push_back(
      {{"name", "lamp"}, {"extensions", file.light({{"type", "point"}, {"range", 5}})}});
  file.node({{"extensions", file.light({{"type", "directional"}, {"intensity", 2}})}});
  file.node({{"extensions", file.light({{"type", "spot"}, {"spot", {{"outerConeAngle", 0.5}}}})}});
  file.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 0.1}}}}};
  file.node({{"name", "eye"}, {"camera", 0}, {"translation", {0, 1, 3}}});
  const auto keys = file.accessor(file.view<float>({0, 1, 2}), 5126, "SCALAR", 3);
  const auto moves = file.accessor(file.view<glm::vec3>({{0, 0, 0}, {1, 0, 0}, {0, 0, 0}}), 5126, "VEC3", 3);
  const auto turns =
      file.accessor(file.view<glm::vec4>({{0, 0, 0, 1}, {0, 1, 0, 0}, {0, 0, 0, -1}}), 5126, "VEC4", 3);
  file.json["animations"] = {
      {{"samplers", {{{"input", keys}, {"output", moves}}, {{"input", keys}, {"output", turns}}}},
       {"channels",
        {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}},
         {{"sampler", 1}, {"target", {{"node", 0}, {"path", "rotation"}}}}}}}};
  return file;
}

std::vector<std::byte> bytes_of_text(std::string_view text) {
  std::vector<std::byte> bytes;
  append(bytes, text.data(), text.size());
  return bytes;
}

Expected<Scene> load_copy(const std::byte* bytes, std::size_t size) {
  const auto exact = std::make_unique<std::byte[]>(size);
  std::copy(bytes, bytes + size, exact.get());
  return load_scene_from_memory({exact.get(), size});
}

std::string outcome_of(const Expected<Scene>& scene) {
  if (!scene) return "refused: " + scene.error().what;
  if (scene->warnings.empty()) return "drawn";
  std::string all;
  for (const std::string& warning : scene->warnings) all += (all.empty() ? "" : "; ") + warning;
  return all;
}

}  // namespace farshade
