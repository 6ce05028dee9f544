/// KHR_draco_mesh_compression. Draco allocates by counts in the compressed bytes, and a few bytes can say
/// 2^30 triangles. So BoundedDecoder reads the counts before Draco does: those of the triangles before it
/// decodes their connectivity, and the sizes of the attributes before it decodes their values. It takes from
/// the budget what Draco will allocate.
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>

#include <cstring>

#include "stereo/gltf/gltf_accessor.h"
#include "stereo/gltf/gltf_stages.h"

namespace farshade::gltf {
namespace {

/// Bytes that Draco 1.5 allocates for a triangle: its corner table, and one more table for each group of
/// attributes that has seams.
constexpr std::uint64_t kTriangleBytes = 96, kSeamBytes = 48;
/// Copies of each value of an attribute: as decoded, before and after its transform, and the accessor's.
constexpr std::uint64_t kCopies = 4;
constexpr std::uint16_t kBitstream = DRACO_BITSTREAM_VERSION(2, 2);

/// The number of triangles, and the tables that Edgebreaker makes for them.
struct Connectivity {
  std::uint32_t triangles = 0, tables = 0;
};

/// Reads ahead: the argument is a copy, so that Draco reads the same bytes again.
std::optional<Connectivity> connectivity_of(draco::DecoderBuffer ahead, draco::MeshEncoderMethod method) {
  std::uint32_t vertices = 0;
  std::uint8_t tables = 0;
  Connectivity result;
  if (method == draco::MESH_SEQUENTIAL_ENCODING)
    return draco::DecodeVarint(&result.triangles, &ahead) ? std::optional(result) : std::nullopt;
  if (!draco::DecodeVarint(&vertices, &ahead) || !draco::DecodeVarint(&result.triangles, &ahead) ||
      !ahead.Decode(&tables))
    return std::nullopt;
  result.tables = tables;
  return result;
}

/// A Draco decoder that decodes nothing for which the budget has not enough bytes.
template <class Decoder, draco::MeshEncoderMethod kMethod>
class BoundedDecoder : public Decoder {
 public:
  BoundedDecoder(std::string name, std::uint64_t triangles, Budget& budget)
      : name_(std::move(name)), triangles_(triangles), budget_(budget) {}

  /// The decoded mesh has as many triangles as the JSON says.
  [[nodiscard]] Expected<std::unique_ptr<draco::Mesh>> decode(draco::DecoderBuffer& buffer) {
    auto mesh = std::make_unique<draco::Mesh>();
    const draco::Status status = this->Decode(draco::DecoderOptions{}, &buffer, mesh.get());
    if (!verdict_) return tl::unexpected(verdict_.error());
    if (!status.ok()) return malformed(name_ + ": " + printable(status.error_msg_string()));
    if (mesh->num_faces() != triangles_) return malformed(name_ + " has another number of triangles");
    return mesh;
  }

 protected:
  bool DecodeConnectivity() override {
    const auto counts = connectivity_of(*this->buffer(), kMethod);
    if (!counts)
      verdict_ = malformed(name_ + " is cut short");
    else if (counts->triangles != triangles_)
      verdict_ = malformed(name_ + " has " + std::to_string(counts->triangles) + " triangles, its accessor " +
                           std::to_string(triangles_));
    else
      verdict_ = budget_.take(triangles_ * (kTriangleBytes + kSeamBytes * counts->tables), name_ + kTooMuch);
    return verdict_ && Decoder::DecodeConnectivity();
  }

  bool DecodeAllAttributes() override {
    const draco::PointCloud& points = *this->point_cloud();
    std::uint64_t value_bytes = 0;  // of one vertex
    for (int i = 0; i < points.num_attributes(); ++i)
      value_bytes += points.attribute(i)->num_components() * sizeof(std::uint32_t) + sizeof(std::uint32_t);
    verdict_ = budget_.take(points.num_points() * value_bytes * kCopies, name_ + kTooMuch);
    return verdict_ && Decoder::DecodeAllAttributes();
  }

 private:
  std::string name_;
  std::uint64_t triangles_;
  Budget& budget_;
  Checked verdict_;
};

Expected<std::unique_ptr<draco::Mesh>> decode_mesh(ByteSpan bytes, const std::string& name,
                                                   std::uint64_t triangles, Budget& budget) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  draco::DecoderBuffer ahead = buffer;
  draco::DracoHeader header;
  if (!draco::PointCloudDecoder::DecodeHeader(&ahead, &header).ok() ||
      header.encoder_type != draco::TRIANGULAR_MESH)
    return malformed(name + " is no mesh of Draco");
  if (DRACO_BITSTREAM_VERSION(header.version_major, header.version_minor) != kBitstream)
    return fail(Fault::Unsupported, name + " has version " + std::to_string(header.version_major) + "." +
                                        std::to_string(header.version_minor) +
                                        " of Draco's format, only 2.2 is read: compress the file again");
  using Sequential = BoundedDecoder<draco::MeshSequentialDecoder, draco::MESH_SEQUENTIAL_ENCODING>;
  using Edgebreaker = BoundedDecoder<draco::MeshEdgebreakerDecoder, draco::MESH_EDGEBREAKER_ENCODING>;
  if (header.encoder_method == draco::MESH_SEQUENTIAL_ENCODING)
    return Sequential(name, triangles, budget).decode(buffer);
  if (header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING)
    return Edgebreaker(name, triangles, budget).decode(buffer);
  return malformed(name + ": unknown method " + std::to_string(header.encoder_method));
}

/// Appends an accessor like number `like` over `bytes`, which lie without gaps. Returns its number.
int add_accessor(Document& document, std::uint32_t like, Bytes bytes) {
  Accessor accessor = document.accessors[like];
  accessor.bufferView = static_cast<int>(document.bufferViews.size());
  accessor.byteOffset = 0;
  BufferView& view = document.bufferViews.emplace_back();
  view.buffer = static_cast<int>(document.buffers.size());
  view.byteLength = bytes.size();
  document.buffers.emplace_back().data = std::move(bytes);
  document.accessors.push_back(std::move(accessor));
  return static_cast<int>(document.accessors.size() - 1);
}

/// The values of all points. False if one does not fit in a T.
template <class T>
bool convert_values(const draco::PointAttribute& from, std::uint32_t points, std::uint32_t rows, Bytes& to) {
  std::array<T, 4> value{};
  const std::size_t row_bytes = rows * sizeof(T);
  to.resize(points * row_bytes);
  for (std::uint32_t i = 0; i < points; ++i) {
    if (!from.ConvertValue<T>(from.mapped_index(draco::PointIndex(i)), static_cast<std::int8_t>(rows),
                              value.data()))
      return false;
    std::memcpy(to.data() + i * row_bytes, value.data(), row_bytes);
  }
  return true;
}

/// Points the primitive's attribute `semantic` at the decoded values.
Checked take_attribute(Document& document, const std::string& name, Primitive& primitive,
                       const std::string& semantic, std::uint32_t id, const draco::Mesh& mesh) {
  const Index number = attribute(primitive, semantic);
  if (!number) return {};  // the primitive does not ask for it
  const std::string subject = name + ": " + printable(semantic);
  const draco::PointAttribute* from = mesh.GetAttributeByUniqueId(id);
  if (!from) return malformed(subject + " is not in the mesh");
  const auto found = accessor_at(document, subject, static_cast<int>(*number));
  if (!found) return tl::unexpected(found.error());
  const Accessor& accessor = **found;
  const Shape shape = shape_of(accessor);
  if (accessor.count != mesh.num_points() || shape.columns != 1 || shape.rows != from->num_components() ||
      accessor.sparse.isSparse)
    return malformed(subject + ": " + label("accessor", *number) + " does not have the mesh's " +
                     std::to_string(mesh.num_points()) + " vertices");
  Bytes values;
  const bool fits = with_type(component_of(accessor), [&](auto zero) {
    return convert_values<decltype(zero)>(*from, mesh.num_points(), shape.rows, values);
  });
  if (!fits)
    return malformed(subject + ": a value does not fit in the type of " + label("accessor", *number));
  primitive.attributes[semantic] = add_accessor(document, *number, std::move(values));
  return {};
}

int take_indices(Document& document, std::uint32_t accessor, const draco::Mesh& mesh) {
  std::vector<std::uint32_t> corners;
  for (std::uint32_t i = 0; i < mesh.num_faces(); ++i)
    for (const auto& corner : mesh.face(draco::FaceIndex(i))) corners.push_back(corner.value());
  const auto* first = reinterpret_cast<const std::uint8_t*>(corners.data());
  const int number =
      add_accessor(document, accessor, Bytes(first, first + sizeof(std::uint32_t) * corners.size()));
  at(document.accessors, number).componentType = static_cast<int>(Component::UInt32);
  return number;
}

/// `draco`: the extension of the primitive.
Checked decompress_primitive(Document& document, const std::string& name, const tinygltf::Value& draco,
                             Primitive& primitive, Budget& budget) {
  const auto indices = accessor_at(document, name + ": index", primitive.indices);
  if (primitive.indices < 0 || primitive.mode != TINYGLTF_MODE_TRIANGLES)
    return malformed(name + " should have triangles with indices");
  if (!indices) return tl::unexpected(indices.error());
  const std::uint64_t triangles = (*indices)->count / 3;
  const auto bytes =
      bytes_of_view(document, static_cast<int>(index_member(&draco, "bufferView").value_or(0)));
  if (!bytes) return malformed(name + ": " + bytes.error().what);
  const auto mesh = decode_mesh(*bytes, name, triangles, budget);
  if (!mesh) return tl::unexpected(mesh.error());
  if (const auto* attributes = member(&draco, "attributes"))
    for (const std::string& semantic : attributes->Keys()) {
      const std::uint32_t id = index_member(attributes, semantic).value_or(0);
      if (auto taken = take_attribute(document, name, primitive, semantic, id, **mesh); !taken) return taken;
    }
  primitive.indices = take_indices(document, static_cast<std::uint32_t>(primitive.indices), **mesh);
  return {};
}

}  // namespace

Checked decompress_draco(Document& document, Budget& budget) {
  for (std::size_t m = 0; m < document.meshes.size(); ++m)
    for (std::size_t p = 0; p < document.meshes[m].primitives.size(); ++p) {
      Primitive& primitive = document.meshes[m].primitives[p];
      const auto* draco = extension(primitive.extensions, "KHR_draco_mesh_compression");
      if (!draco || !has_triangles(primitive)) continue;
      const std::string name =
          "the Draco mesh of " + label("mesh", m, document.meshes[m].name) + ", " + label("primitive", p);
      Checked decoded = decompress_primitive(document, name, *draco, primitive, budget);
      decoded = mended(std::move(decoded), document.repairs, kNotDrawn, [&] { primitive = {}; });
      if (!decoded) return decoded;
    }
  return {};
}

}  // namespace farshade::gltf
