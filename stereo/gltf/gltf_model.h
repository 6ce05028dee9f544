/// The content of a glTF file as tinygltf stores it (Document), and short words for what the loader asks of
/// it. gltf_read.cpp fills a Document; the members of the file have the right types then, but indices and
/// ranges may still be wrong. The stages (gltf_stages.h) mend them before the Document is converted to a
/// Scene.
#pragma once

#include <tiny_gltf.h>

#include <algorithm>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vector_relational.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stereo/base/expected.h"
#include "stereo/base/printable.h"
#include "stereo/gltf/gltf_repairs.h"

namespace farshade::gltf {

using tinygltf::Accessor;
using tinygltf::Animation;
using tinygltf::AnimationChannel;
using tinygltf::AnimationSampler;
using tinygltf::BufferView;
using tinygltf::Light;
using tinygltf::Material;
using tinygltf::Mesh;
using tinygltf::Node;
using tinygltf::Primitive;
using tinygltf::Skin;

using Checked = Expected<void>;
using Bytes = std::vector<std::uint8_t>;
using ByteSpan = std::span<const std::uint8_t>;

/// An index that may be absent. tinygltf writes -1 then.
inline constexpr std::uint32_t kMaxIndex = (std::uint32_t{1} << 31) - 1;  ///< an int holds it
using Index = std::optional<std::uint32_t>;
[[nodiscard]] inline Index index_of(int index) {
  return index < 0 ? Index{} : Index{static_cast<std::uint32_t>(index)};
}

/// The file, and what the loader finds beside it. Nobody reads the names of buffers, buffer views and
/// accessors in the file: here they say why one cannot be used, and are empty if it can.
struct Document : tinygltf::Model {
  std::vector<std::optional<Error>> unreadable;  ///< for each image: why its external file could not be read
  Index camera;                                  ///< node (choose_camera)
  std::vector<std::string> clips;                ///< all animations of the file, also those that do not play
  std::vector<std::string> warnings;             ///< what is not drawn as the file says, one sentence each
  Repairs repairs;                               ///< faults of the file, and what is drawn instead
};

/// What a file may still use of a limit that grows with its size.
class Budget {
 public:
  explicit Budget(std::uint64_t all) : left_(all) {}

  /// OutOfRange with `fault` if less than `amount` is left.
  [[nodiscard]] Checked take(std::uint64_t amount, std::string fault) {
    if (amount > left_) return fail(Fault::OutOfRange, std::move(fault));
    left_ -= amount;
    return {};
  }

 private:
  std::uint64_t left_;
};

/// The bytes of all buffers.
[[nodiscard]] inline std::uint64_t buffer_bytes(const Document& document) {
  std::uint64_t bytes = 0;
  for (const auto& buffer : document.buffers) bytes += buffer.data.size();
  return bytes;
}

/// The limit on the elements of all accessors together, and on the elements that all primitives read:
/// 2^22 + 8 * bytes of all buffers, at most 2^30. It bounds the work that a small hostile file can cause.
[[nodiscard]] inline std::uint64_t element_budget(const Document& document) {
  return std::min((std::uint64_t{1} << 22) + 8 * buffer_bytes(document), std::uint64_t{1} << 30);
}

/// True if the index is absent or in range for `list`.
template <class List>
[[nodiscard]] bool points_into(const List& list, int index) {
  return index < 0 || static_cast<std::size_t>(index) < list.size();
}

/// `list[index]`. The index must be in range.
template <class List>
[[nodiscard]] auto& at(List& list, int index) {
  return list[static_cast<std::size_t>(index)];
}

// Accessors.

enum class Component : int { Int8 = 5120, UInt8, Int16, UInt16, UInt32 = 5125, Float };

[[nodiscard]] inline Component component_of(const Accessor& accessor) {
  return static_cast<Component>(accessor.componentType);
}

/// Size of a component in bytes.
[[nodiscard]] constexpr std::uint64_t bytes_of(Component c) {
  return c < Component::Int16 ? 1 : c < Component::UInt32 ? 2 : 4;
}

/// The rows and columns of an element. A vector has one column.
struct Shape {
  std::uint32_t rows = 1, columns = 1;
};
[[nodiscard]] inline Shape shape_of(const Accessor& accessor) {
  // TINYGLTF_TYPE_VEC2 to 4 are 2 to 4, MAT2 to 4 are 34 to 36, and SCALAR is 65.
  const auto rows = static_cast<std::uint32_t>(accessor.type % 32);
  return {rows, accessor.type / 32 == 1 ? rows : 1};
}

/// Columns of a matrix are aligned to four bytes.
[[nodiscard]] inline std::uint64_t element_bytes(const Accessor& accessor) {
  const Shape shape = shape_of(accessor);
  const std::uint64_t column = shape.rows * bytes_of(component_of(accessor));
  return shape.columns == 1 ? column : shape.columns * ((column + 3) / 4 * 4);
}

// Meshes and nodes.

/// The roots of the default scene, which is the first one if the file does not say. It must be there.
[[nodiscard]] inline const std::vector<int>& roots_of(const Document& document) {
  return at(document.scenes, std::max(document.defaultScene, 0)).nodes;
}

/// The accessor of an attribute of a primitive or of a morph target.
[[nodiscard]] inline Index attribute(const std::map<std::string, int>& attributes,
                                     const std::string& semantic) {
  const auto found = attributes.find(semantic);
  return found == attributes.end() ? Index{} : index_of(found->second);
}
[[nodiscard]] inline Index attribute(const Primitive& primitive, const std::string& semantic) {
  return attribute(primitive.attributes, semantic);
}

[[nodiscard]] inline bool has_triangles(const Primitive& primitive) {
  return primitive.mode >= TINYGLTF_MODE_TRIANGLES && primitive.mode <= TINYGLTF_MODE_TRIANGLE_FAN &&
         attribute(primitive, "POSITION");
}

/// The morph targets of the primitive that has most.
[[nodiscard]] inline std::size_t targets_of(const Mesh& mesh) {
  std::size_t most = 0;
  for (const Primitive& primitive : mesh.primitives) most = std::max(most, primitive.targets.size());
  return most;
}

/// A vector of the file; `otherwise` if it is absent.
template <class Vector>
[[nodiscard]] Vector vector_of(const std::vector<double>& from, Vector otherwise) {
  if (!from.empty())
    for (int i = 0; i < Vector::length(); ++i) otherwise[i] = from[static_cast<std::size_t>(i)];
  return otherwise;
}
/// Whether all parts of a vector lie within +-most. False for NaN.
template <class Vector>
[[nodiscard]] bool lies_within(double most, const Vector& vector) {
  return glm::all(
      glm::lessThanEqual(glm::abs(vector), Vector(static_cast<typename Vector::value_type>(most))));
}
[[nodiscard]] inline glm::dvec3 translation_of(const Node& node) {
  return vector_of(node.translation, glm::dvec3(0.0));
}
[[nodiscard]] inline glm::dvec3 scale_of(const Node& node) {
  return vector_of(node.scale, glm::dvec3(1.0));
}
[[nodiscard]] inline glm::dquat rotation_of(const Node& node) {
  const auto r = vector_of(node.rotation, glm::dvec4(0, 0, 0, 1));
  return {r.w, r.x, r.y, r.z};
}
[[nodiscard]] inline std::optional<glm::dmat4> matrix_of(const Node& node) {
  if (node.matrix.empty()) return std::nullopt;
  return glm::make_mat4(node.matrix.data());
}

// Extensions. Their members have the types of the table in gltf_members.cpp.

/// The extension `name`; null if it is absent.
[[nodiscard]] inline const tinygltf::Value* extension(const tinygltf::ExtensionMap& of,
                                                      const std::string& name) {
  const auto found = of.find(name);
  return found == of.end() ? nullptr : &found->second;
}

/// Member `name` of a value; null, no index, or what else stands for it, if it or `of` is absent.
[[nodiscard]] inline const tinygltf::Value* member(const tinygltf::Value* of, const std::string& name) {
  return of && of->Has(name) ? &of->Get(name) : nullptr;
}
[[nodiscard]] inline Index index_member(const tinygltf::Value* of, const std::string& name) {
  const auto* value = member(of, name);
  return value ? index_of(value->GetNumberAsInt()) : Index{};
}
[[nodiscard]] inline std::string text_member(const tinygltf::Value* of, const std::string& name,
                                             const std::string& otherwise = "") {
  const auto* value = member(of, name);
  return value ? value->Get<std::string>() : otherwise;
}
[[nodiscard]] inline const tinygltf::Value::Array& list_member(const tinygltf::Value* of, const char* name) {
  static const tinygltf::Value::Array none;
  const auto* value = member(of, name);
  return value ? value->Get<tinygltf::Value::Array>() : none;
}
template <class Vector>
[[nodiscard]] Vector vector_member(const tinygltf::Value* of, const std::string& name, Vector otherwise) {
  if (const auto* value = member(of, name))
    for (int i = 0; i < Vector::length(); ++i) otherwise[i] = value->Get(i).GetNumberAsDouble();
  return otherwise;
}

/// The light of a node (KHR_lights_punctual).
[[nodiscard]] inline Index light_of(const Node& node) {
  return index_member(extension(node.extensions, "KHR_lights_punctual"), "light");
}

/// KHR_node_visibility.
[[nodiscard]] inline bool is_visible(const Node& node) {
  const auto* visible = member(extension(node.extensions, "KHR_node_visibility"), "visible");
  return !visible || visible->Get<bool>();
}
/// The path of a channel that animates it.
inline constexpr std::string_view kVisiblePath = "extensions/KHR_node_visibility/visible";

/// Whether a channel animates a light: its path is "color" or "spot/outerConeAngle", its node the number of
/// the light. resolve_pointers keeps the extensions of no other channel.
[[nodiscard]] inline bool moves_light(const AnimationChannel& channel) {
  return !channel.target_extensions.empty();
}

// Sentences.

/// "mesh 3 'chair'", or "mesh 3" without a name.
template <class Number>
[[nodiscard]] std::string label(std::string_view kind, Number index, std::string_view name = {}) {
  std::string result = std::string(kind) + ' ' + std::to_string(index);
  if (!name.empty()) result += " '" + printable(name) + "'";
  return result;
}

[[nodiscard]] inline tl::unexpected<Error> malformed(std::string what) {
  return fail(Fault::Malformed, std::move(what));
}

}  // namespace farshade::gltf
