/// Elements of validated accessors as vectors of numbers: strides, sparse parts and normalised integers are
/// undone.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "stereo/scene/gltf_document.h"

namespace farshade::gltf {

/// Where the elements of `accessor` start in its buffer, and how far they are apart; null where it has no
/// view.
struct ElementRun {
  const std::uint8_t* first = nullptr;
  std::uint64_t stride = 0;
};
[[nodiscard]] ElementRun elements_of(const Document& document, const Accessor& accessor);

/// Elements with N components as floats. Missing ones (a three-component colour read as four) are 1.
template <int N>
[[nodiscard]] std::vector<glm::vec<N, float>> read_vectors(const Document& document, std::uint32_t accessor);

/// Scalars as floats (animation keys).
[[nodiscard]] std::vector<float> read_scalars(const Document& document, std::uint32_t accessor);

/// Unsigned scalars (vertex indices).
[[nodiscard]] std::vector<std::uint32_t> read_indices(const Document& document, std::uint32_t accessor);

/// The element numbers that a sparse accessor overwrites.
[[nodiscard]] std::vector<std::uint32_t> sparse_indices(const Document& document, const Sparse& sparse);

}  // namespace farshade::gltf
