/// Finds buffer views and accessors, and reads the elements of validated accessors as numbers. Handles
/// strides, sparse elements and normalised integers.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "stereo/base/check.h"
#include "stereo/gltf/gltf_model.h"

namespace farshade::gltf {

/// Calls `use` with a value of the component's C++ type.
template <class Use>
auto with_type(Component component, Use use) {
  if (component == Component::Int8) return use(std::int8_t{});
  if (component == Component::UInt8) return use(std::uint8_t{});
  if (component == Component::Int16) return use(std::int16_t{});
  if (component == Component::UInt16) return use(std::uint16_t{});
  if (component == Component::UInt32) return use(std::uint32_t{});
  check(component == Component::Float, "validated component type");
  return use(float{});
}

/// `bytes` bytes of a buffer from `offset` on, or why `name` cannot read them.
[[nodiscard]] Expected<ByteSpan> bytes_in_buffer(const Document& document, const std::string& name,
                                                 int buffer, std::size_t offset, std::size_t bytes);

/// The bytes of a buffer view, or why they cannot be read.
[[nodiscard]] Expected<ByteSpan> bytes_of_view(const Document& document, int view);

/// The accessor `index`, or why it cannot be read. `user` names what reads it: "mesh 3, primitive 0:
/// POSITION". validate_accessors must have looked for faults.
[[nodiscard]] Expected<const Accessor*> accessor_at(const Document& document, const std::string& user,
                                                    int index);

/// Kinds of numbers, as bits. Integers have 8 or 16 bits unless the name says 32.
inline constexpr unsigned kFloats = 1, kSigned = 2, kUnsigned = 4, kUnsigned32 = 8, kNormalizedSigned = 16,
                          kNormalizedUnsigned = 32,
                          kFloatsOrNormalized = kFloats | kNormalizedSigned | kNormalizedUnsigned,
                          kFloatsOrShort = kFloatsOrNormalized | kSigned | kUnsigned;

/// The elements that a reader can read.
struct Elements {
  unsigned numbers;  ///< one or more kinds
  std::uint32_t least_rows, most_rows = least_rows, columns = 1;
};

/// As accessor_at, for a reader of some elements. Otherwise `fault` follows the name of the accessor.
[[nodiscard]] Expected<const Accessor*> accessor_of(const Document& document, const std::string& user,
                                                    int index, const Elements& elements,
                                                    const std::string& fault);

/// The accessor of an attribute, which has a value for each of `count` vertices or instances (`what`).
[[nodiscard]] Expected<const Accessor*> attribute_of(const Document& document, const std::string& user,
                                                     std::uint32_t index, const Elements& elements,
                                                     std::optional<std::uint64_t> count, const char* what);

/// Elements with N components, as floats; none without an accessor. Missing components (alpha of an RGB
/// colour) are 1.
template <int N>
[[nodiscard]] std::vector<glm::vec<N, float>> read_vectors(const Document& document, Index accessor);

/// Matrices of 4x4 floats.
[[nodiscard]] std::vector<glm::mat4> read_matrices(const Document& document, std::uint32_t accessor);

/// Scalars as floats (animation keys).
[[nodiscard]] std::vector<float> read_scalars(const Document& document, std::uint32_t accessor);

/// Unsigned scalars (vertex indices).
[[nodiscard]] std::vector<std::uint32_t> read_indices(const Document& document, std::uint32_t accessor);

}  // namespace farshade::gltf
