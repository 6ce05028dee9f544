#include "stereo/gltf/gltf_accessor.h"

#include <cstring>
#include <limits>

#include "stereo/base/check.h"

namespace farshade::gltf {
namespace {

const std::uint8_t* bytes_at(const Document& document, int view, std::size_t offset) {
  const BufferView& v = at(document.bufferViews, view);
  return at(document.buffers, v.buffer).data.data() + v.byteOffset + offset;
}

template <class T>
T load(const std::uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

/// Normalised integers by glTF 2.0 section 3.11: value / maximum of the type, at least -1.
template <class T>
float load_number(const std::uint8_t* bytes, bool normalized) {
  const T value = load<T>(bytes);
  if constexpr (std::is_same_v<T, float>) return value;
  if (!normalized) return static_cast<float>(value);
  return std::max(static_cast<float>(value) / static_cast<float>(std::numeric_limits<T>::max()), -1.0f);
}

/// Calls `read` with a value of the component's C++ type.
template <class Read>
void with_type(Component component, Read read) {
  switch (component) {
    case Component::Int8:
      return read(std::int8_t{});
    case Component::UInt8:
      return read(std::uint8_t{});
    case Component::Int16:
      return read(std::int16_t{});
    case Component::UInt16:
      return read(std::uint16_t{});
    case Component::UInt32:
      return read(std::uint32_t{});
    case Component::Float:
      return read(float{});
  }
  check(false, "validated component type");
}

/// Calls `store(index, address, zero)` for each dense element, then for each sparse element. `zero` has the
/// C++ type of a component.
template <class Store>
void for_each_element(const Document& document, const Accessor& accessor, Store store) {
  const ElementRun run = elements_of(document, accessor);
  const std::vector<std::uint32_t> numbers = sparse_indices(document, accessor);
  with_type(component_of(accessor), [&](auto zero) {
    if (run.first)
      for (std::uint64_t i = 0; i < accessor.count; ++i) store(i, run.first + i * run.stride, zero);
    if (!accessor.sparse.isSparse) return;
    const auto& sparse = accessor.sparse.values;
    const auto* values = bytes_at(document, sparse.bufferView, static_cast<std::size_t>(sparse.byteOffset));
    for (std::size_t i = 0; i < numbers.size(); ++i)
      store(numbers[i], values + i * element_bytes(accessor), zero);
  });
}

}  // namespace

Expected<std::span<const std::uint8_t>> bytes_in_buffer(const Document& document, const std::string& name,
                                                        int number, std::size_t offset, std::size_t bytes) {
  if (!points_into(document.buffers, number) || number < 0)
    return malformed(name + ": there is no " + label("buffer", number));
  const tinygltf::Buffer& buffer = at(document.buffers, number);
  const std::span<const std::uint8_t> all = buffer.data;
  if (offset <= all.size() && bytes <= all.size() - offset) return all.subspan(offset, bytes);
  if (!buffer.name.empty()) return malformed(buffer.name);
  return malformed(name + " reads beyond its buffer (" + std::to_string(all.size()) + " bytes)");
}

Expected<std::span<const std::uint8_t>> bytes_of_view(const Document& document, int index) {
  const std::string name = label("buffer view", index);
  if (!points_into(document.bufferViews, index) || index < 0) return malformed("there is no " + name);
  const BufferView& view = at(document.bufferViews, index);
  if (!view.name.empty()) return malformed(view.name);
  return bytes_in_buffer(document, name, view.buffer, view.byteOffset, view.byteLength);
}

Expected<const Accessor*> accessor_at(const Document& document, const std::string& user, int index) {
  if (!points_into(document.accessors, index) || index < 0)
    return malformed(user + " " + label("accessor", index) + " is not there");
  const Accessor& accessor = at(document.accessors, index);
  if (accessor.name.empty()) return &accessor;
  return malformed(user + ": " + accessor.name);
}

ElementRun elements_of(const Document& document, const Accessor& accessor) {
  if (accessor.bufferView < 0) return {};
  const std::uint64_t stride = at(document.bufferViews, accessor.bufferView).byteStride;
  return {bytes_at(document, accessor.bufferView, accessor.byteOffset),
          stride ? stride : element_bytes(accessor)};
}

template <int N>
std::vector<glm::vec<N, float>> read_vectors(const Document& document, std::uint32_t index) {
  const Accessor& accessor = document.accessors[index];
  const std::size_t width = std::min<std::size_t>(shape_of(accessor).rows, N);
  glm::vec<N, float> rest(0.0f);
  for (std::size_t i = width; i < N; ++i) rest[static_cast<int>(i)] = 1.0f;
  std::vector<glm::vec<N, float>> result(accessor.count, rest);
  for_each_element(document, accessor, [&](std::uint64_t i, const std::uint8_t* bytes, auto zero) {
    for (std::size_t c = 0; c < width; ++c)
      result[i][static_cast<int>(c)] =
          load_number<decltype(zero)>(bytes + c * sizeof zero, accessor.normalized);
  });
  return result;
}
template std::vector<glm::vec2> read_vectors<2>(const Document&, std::uint32_t);
template std::vector<glm::vec3> read_vectors<3>(const Document&, std::uint32_t);
template std::vector<glm::vec4> read_vectors<4>(const Document&, std::uint32_t);

std::vector<glm::mat4> read_matrices(const Document& document, std::uint32_t index) {
  const Accessor& accessor = document.accessors[index];
  std::vector<glm::mat4> result(accessor.count, glm::mat4(0.0f));
  for_each_element(document, accessor, [&](std::uint64_t i, const std::uint8_t* bytes, auto zero) {
    for (std::size_t c = 0; c < 16; ++c)
      result[i][static_cast<int>(c / 4)][static_cast<int>(c % 4)] =
          load_number<decltype(zero)>(bytes + c * sizeof zero, false);
  });
  return result;
}

std::vector<float> read_scalars(const Document& document, std::uint32_t index) {
  const Accessor& accessor = document.accessors[index];
  std::vector<float> result(accessor.count);
  for_each_element(document, accessor, [&](std::uint64_t i, const std::uint8_t* bytes, auto zero) {
    result[i] = load_number<decltype(zero)>(bytes, accessor.normalized);
  });
  return result;
}

std::vector<std::uint32_t> read_indices(const Document& document, std::uint32_t index) {
  const Accessor& accessor = document.accessors[index];
  std::vector<std::uint32_t> result(accessor.count);
  for_each_element(document, accessor, [&](std::uint64_t i, const std::uint8_t* bytes, auto zero) {
    // Indices are unsigned. NOLINTNEXTLINE(bugprone-signed-char-misuse)
    result[i] = static_cast<std::uint32_t>(load<decltype(zero)>(bytes));
  });
  return result;
}

std::vector<std::uint32_t> sparse_indices(const Document& document, const Accessor& accessor) {
  if (!accessor.sparse.isSparse) return {};
  const auto& from = accessor.sparse.indices;
  std::vector<std::uint32_t> result(static_cast<std::size_t>(accessor.sparse.count));
  const auto* bytes = bytes_at(document, from.bufferView, static_cast<std::size_t>(from.byteOffset));
  with_type(static_cast<Component>(from.componentType), [&](auto type) {
    using T = decltype(type);
    for (std::size_t i = 0; i < result.size(); ++i)
      // NOLINTNEXTLINE(bugprone-signed-char-misuse)
      result[i] = static_cast<std::uint32_t>(load<T>(bytes + i * sizeof(T)));
  });
  return result;
}

}  // namespace farshade::gltf
