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
[[nodiscard]] Expected<std::span<const std::uint8_t>> bytes_in_buffer(const Document& document,
                                                                      const std::string& name, int buffer,
                                                                      std::size_t offset, std::size_t bytes);

/// The bytes of a buffer view, or why they cannot be read.
[[nodiscard]] Expected<std::span<const std::uint8_t>> bytes_of_view(const Document& document, int view);

/// The accessor `index`, or why it cannot be read. `user` names what reads it: "mesh 3, primitive 0:
/// POSITION". validate_accessors must have looked for faults.
[[nodiscard]] Expected<const Accessor*> accessor_at(const Document& document, const std::string& user,
                                                    int index);

/// The first element that is not finite.
[[nodiscard]] std::optional<std::uint64_t> first_not_finite(const Document& document,
                                                            const Accessor& accessor);

/// Elements with N components, as floats. Missing components (alpha of an RGB colour) are 1.
template <int N>
[[nodiscard]] std::vector<glm::vec<N, float>> read_vectors(const Document& document, std::uint32_t accessor);

/// Matrices of 4x4 floats.
[[nodiscard]] std::vector<glm::mat4> read_matrices(const Document& document, std::uint32_t accessor);

/// Scalars as floats (animation keys).
[[nodiscard]] std::vector<float> read_scalars(const Document& document, std::uint32_t accessor);

/// Unsigned scalars (vertex indices).
[[nodiscard]] std::vector<std::uint32_t> read_indices(const Document& document, std::uint32_t accessor);

/// The indices of the elements that a sparse accessor replaces. Empty for any other.
[[nodiscard]] std::vector<std::uint32_t> sparse_indices(const Document& document, const Accessor& accessor);

}  // namespace farshade::gltf
