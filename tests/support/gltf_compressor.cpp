#include "tests/support/gltf_compressor.h"

#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>
#include <meshoptimizer.h>

#include <cstdint>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>

namespace farshade {
namespace {

using nlohmann::json;
using Bytes = std::vector<unsigned char>;

struct Glb {
  json text;
  Bytes binary;
};

std::uint32_t u32_at(std::span<const std::byte> file, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, file.data() + at, sizeof value);
  return value;
}

Glb open(std::span<const std::byte> file) {
  const std::size_t text_bytes = u32_at(file, 12), binary_at = 20 + text_bytes + 8;
  const auto* first = reinterpret_cast<const char*>(file.data());
  Glb glb{json::parse(first + 20, first + 20 + text_bytes), {}};
  if (binary_at < file.size()) glb.binary.assign(first + binary_at, first + file.size());
  return glb;
}

void append(std::vector<std::byte>& file, const void* data, std::size_t size) {
  const auto* first = static_cast<const std::byte*>(data);
  file.insert(file.end(), first, first + size);
}

void append_u32(std::vector<std::byte>& file, std::size_t value) {
  const auto narrow = static_cast<std::uint32_t>(value);
  append(file, &narrow, sizeof narrow);
}

std::vector<std::byte> close(const Glb& glb) {
  std::string text = glb.text.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::vector<std::byte> file;
  append(file, "glTF", 4);
  append_u32(file, 2);
  append_u32(file, 28 + text.size() + glb.binary.size());
  append_u32(file, text.size());
  append(file, "JSON", 4);
  append(file, text.data(), text.size());
  append_u32(file, glb.binary.size());
  append(file, "BIN\0", 4);
  append(file, glb.binary.data(), glb.binary.size());
  return file;
}

/// Appends to the binary chunk, aligned to four bytes. Returns where.
std::size_t add(Bytes& binary, const void* data, std::size_t size) {
  const std::size_t at = binary.size();
  const auto* first = static_cast<const unsigned char*>(data);
  binary.insert(binary.end(), first, first + size);
  binary.resize((binary.size() + 3) / 4 * 4);
  return at;
}

std::size_t component_bytes(const json& accessor) {
  const int type = accessor["componentType"];
  return type <= 5121 ? 1 : type <= 5123 ? 2 : 4;
}

std::size_t components(const json& accessor) {
  static const std::map<std::string, std::size_t> kCounts{
      {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}};
  return kCounts.at(accessor["type"]);
}

/// The indices of all primitives' index accessors.
std::set<std::size_t> index_accessors(const json& text) {
  std::set<std::size_t> found;
  for (const json& mesh : text.value("meshes", json::array()))
    for (const json& primitive : mesh["primitives"])
      if (primitive.contains("indices")) found.insert(primitive["indices"].get<std::size_t>());
  return found;
}

/// How meshoptimizer encodes a view; none: it stays as it is.
struct Encoding {
  std::size_t stride = 0, count = 0;
  bool is_index = false;
};

std::optional<Encoding> encoding_of(const json& text, std::size_t view) {
  const std::set<std::size_t> indices = index_accessors(text);
  std::optional<Encoding> result;
  for (std::size_t a = 0; a < text["accessors"].size(); ++a) {
    const json& accessor = text["accessors"][a];
    if (accessor.value("bufferView", view + 1) != view) continue;
    const json& of = text["bufferViews"][view];
    const std::size_t stride = of.value("byteStride", components(accessor) * component_bytes(accessor));
    result = Encoding{stride, of["byteLength"].get<std::size_t>() / stride, indices.contains(a)};
    const bool fits = result->is_index ? stride >= 2 : stride % 4 == 0;
    if (!fits || of["byteLength"] != stride * result->count) return std::nullopt;
  }
  return result;
}

Bytes encode_indices(const unsigned char* from, const Encoding& encoding, IndexCodec codec) {
  std::vector<unsigned> indices(encoding.count);
  for (std::size_t i = 0; i < indices.size(); ++i)
    std::memcpy(&indices[i], from + i * encoding.stride, encoding.stride);
  Bytes bytes(64 + 16 * indices.size());
  bytes.resize(codec == IndexCodec::Triangles
                   ? meshopt_encodeIndexBuffer(bytes.data(), bytes.size(), indices.data(), indices.size())
                   : meshopt_encodeIndexSequence(bytes.data(), bytes.size(), indices.data(), indices.size()));
  return bytes;
}

Bytes encode_vertices(const unsigned char* from, const Encoding& encoding) {
  Bytes bytes(meshopt_encodeVertexBufferBound(encoding.count, encoding.stride));
  bytes.resize(meshopt_encodeVertexBuffer(bytes.data(), bytes.size(), from, encoding.count, encoding.stride));
  return bytes;
}

draco::DataType draco_type(const json& accessor) {
  static const std::map<int, draco::DataType> kTypes{{5120, draco::DT_INT8},   {5121, draco::DT_UINT8},
                                                     {5122, draco::DT_INT16},  {5123, draco::DT_UINT16},
                                                     {5125, draco::DT_UINT32}, {5126, draco::DT_FLOAT32}};
  return kTypes.at(accessor["componentType"]);
}

draco::GeometryAttribute::Type draco_kind(const std::string& semantic) {
  if (semantic == "POSITION") return draco::GeometryAttribute::POSITION;
  if (semantic == "NORMAL") return draco::GeometryAttribute::NORMAL;
  if (semantic.starts_with("COLOR")) return draco::GeometryAttribute::COLOR;
  if (semantic.starts_with("TEXCOORD")) return draco::GeometryAttribute::TEX_COORD;
  return draco::GeometryAttribute::GENERIC;
}

/// The address of an accessor's first element, and the bytes between elements.
std::pair<const unsigned char*, std::size_t> elements(const Glb& glb, const json& accessor) {
  const json& view = glb.text["bufferViews"][accessor["bufferView"].get<std::size_t>()];
  return {glb.binary.data() + view.value("byteOffset", 0u) + accessor.value("byteOffset", 0u),
          view.value("byteStride", components(accessor) * component_bytes(accessor))};
}

/// Returns the attribute's unique id.
std::uint32_t add_attribute(const Glb& glb, const std::string& semantic, const json& accessor,
                            draco::Mesh& mesh) {
  const auto [first, stride] = elements(glb, accessor);
  const std::size_t size = components(accessor) * component_bytes(accessor);
  draco::GeometryAttribute attribute;
  attribute.Init(draco_kind(semantic), nullptr, static_cast<std::uint8_t>(components(accessor)),
                 draco_type(accessor), accessor.value("normalized", false), static_cast<std::int64_t>(size),
                 0);
  const std::uint32_t count = accessor["count"];
  const int id = mesh.AddAttribute(attribute, true, count);
  for (std::uint32_t i = 0; i < count; ++i)
    mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i), first + i * stride);
  return mesh.attribute(id)->unique_id();
}

void add_faces(const Glb& glb, const json& accessor, draco::Mesh& mesh) {
  const auto [first, stride] = elements(glb, accessor);
  const std::size_t size = component_bytes(accessor);
  std::uint32_t corner[3]{};
  for (std::uint32_t i = 0; i < accessor["count"].get<std::uint32_t>(); ++i) {
    corner[i % 3] = 0;
    std::memcpy(&corner[i % 3], first + i * stride, size);
    if (i % 3 == 2)
      mesh.AddFace(
          {draco::PointIndex(corner[0]), draco::PointIndex(corner[1]), draco::PointIndex(corner[2])});
  }
}

/// The primitive's Draco extension without a buffer view, and the encoded mesh.
std::pair<json, Bytes> encode_draco(const Glb& glb, const json& primitive, DracoMethod method) {
  draco::Mesh mesh;
  json ids;
  for (const auto& [semantic, accessor] : primitive["attributes"].items())
    ids[semantic] = add_attribute(glb, semantic, glb.text["accessors"][accessor.get<std::size_t>()], mesh);
  const json& positions = glb.text["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()];
  mesh.set_num_points(positions["count"]);
  add_faces(glb, glb.text["accessors"][primitive["indices"].get<std::size_t>()], mesh);
  draco::ExpertEncoder encoder(mesh);
  encoder.SetEncodingMethod(method == DracoMethod::Sequential ? draco::MESH_SEQUENTIAL_ENCODING
                                                              : draco::MESH_EDGEBREAKER_ENCODING);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeToBuffer(&buffer).ok()) throw std::runtime_error("Draco cannot encode a mesh");
  return {json{{"attributes", ids}}, Bytes(buffer.data(), buffer.data() + buffer.size())};
}

bool can_be_draco(const json& text, const json& primitive) {
  if (!primitive.contains("indices") || primitive.value("mode", 4) != 4) return false;
  for (const auto& [semantic, accessor] : primitive["attributes"].items())
    if (text["accessors"][accessor.get<std::size_t>()].contains("sparse")) return false;
  return true;
}

/// Takes the bytes out of an accessor and its view: only the compressed ones are left.
void empty(json& text, std::size_t accessor) {
  text["accessors"][accessor].erase("bufferView");
  text["accessors"][accessor].erase("byteOffset");
}

}  // namespace

std::vector<std::byte> compress_with_meshopt(std::span<const std::byte> file, IndexCodec codec) {
  const Glb from = open(file);
  Glb to{from.text, {}};
  std::size_t fallback_bytes = 0;
  for (std::size_t v = 0; v < from.text["bufferViews"].size(); ++v) {
    json& view = to.text["bufferViews"][v];
    const std::size_t bytes = view["byteLength"];
    const unsigned char* first = from.binary.data() + view.value("byteOffset", 0u);
    const auto encoding = encoding_of(from.text, v);
    if (!encoding) {
      view["byteOffset"] = add(to.binary, first, bytes);
      continue;
    }
    const Bytes encoded =
        encoding->is_index ? encode_indices(first, *encoding, codec) : encode_vertices(first, *encoding);
    const char* indices = codec == IndexCodec::Triangles ? "TRIANGLES" : "INDICES";
    view["extensions"]["EXT_meshopt_compression"] = {
        {"buffer", 0},
        {"byteOffset", add(to.binary, encoded.data(), encoded.size())},
        {"byteLength", encoded.size()},
        {"byteStride", encoding->stride},
        {"count", encoding->count},
        {"mode", encoding->is_index ? indices : "ATTRIBUTES"}};
    view["buffer"] = 1;
    view["byteOffset"] = fallback_bytes;
    fallback_bytes += (bytes + 3) / 4 * 4;
  }
  to.text["buffers"] = {{{"byteLength", to.binary.size()}},
                        {{"byteLength", fallback_bytes + 4},
                         {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
  to.text["extensionsRequired"].push_back("EXT_meshopt_compression");
  return close(to);
}

std::vector<std::byte> compress_with_draco(std::span<const std::byte> file, DracoMethod method) {
  const Glb from = open(file);
  Glb to = from;
  std::set<std::size_t> emptied, kept;
  for (json& mesh : to.text["meshes"])
    for (json& primitive : mesh["primitives"]) {
      const bool packs = can_be_draco(from.text, primitive);
      auto& list = packs ? emptied : kept;
      for (const auto& [semantic, accessor] : primitive["attributes"].items())
        list.insert(accessor.get<std::size_t>());
      if (primitive.contains("indices")) list.insert(primitive["indices"].get<std::size_t>());
      if (!packs) continue;
      auto [extension, buffer] = encode_draco(from, primitive, method);
      extension["bufferView"] = to.text["bufferViews"].size();
      primitive["extensions"]["KHR_draco_mesh_compression"] = extension;
      to.text["bufferViews"].push_back({{"buffer", 0},
                                        {"byteOffset", add(to.binary, buffer.data(), buffer.size())},
                                        {"byteLength", buffer.size()}});
    }
  for (const std::size_t accessor : emptied)
    if (!kept.contains(accessor)) empty(to.text, accessor);
  to.text["buffers"] = {{{"byteLength", to.binary.size()}}};
  to.text["extensionsRequired"].push_back("KHR_draco_mesh_compression");
  return close(to);
}

}  // namespace farshade
