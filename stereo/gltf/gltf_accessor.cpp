#include "stereo/gltf/gltf_accessor.h"

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "stereo/gltf/gltf_stages.h"

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

/// The indices of the elements that a sparse accessor replaces. Empty for any other.
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

/// Calls `store(index, address, zero)` for each dense element, then for each sparse element. `zero` has the
/// C++ type of a component.
template <class Store>
void for_each_element(const Document& document, const Accessor& accessor, Store store) {
  const std::vector<std::uint32_t> numbers = sparse_indices(document, accessor);
  with_type(component_of(accessor), [&](auto zero) {
    if (accessor.bufferView >= 0) {
      const std::uint8_t* first = bytes_at(document, accessor.bufferView, accessor.byteOffset);
      const std::uint64_t given = at(document.bufferViews, accessor.bufferView).byteStride,
                          stride = given ? given : element_bytes(accessor);
      for (std::uint64_t i = 0; i < accessor.count; ++i) store(i, first + i * stride, zero);
    }
    if (!accessor.sparse.isSparse) return;
    const auto& sparse = accessor.sparse.values;
    const auto* values = bytes_at(document, sparse.bufferView, static_cast<std::size_t>(sparse.byteOffset));
    for (std::size_t i = 0; i < numbers.size(); ++i)
      store(numbers[i], values + i * element_bytes(accessor), zero);
  });
}

unsigned numbers_of(const Accessor& accessor) {
  const Component component = component_of(accessor);
  if (component == Component::Float) return kFloats;
  if (component == Component::UInt32) return accessor.normalized ? 0u : kUnsigned32;
  if (component == Component::Int8 || component == Component::Int16)
    return accessor.normalized ? kNormalizedSigned : kSigned;
  return accessor.normalized ? kNormalizedUnsigned : kUnsigned;
}

/// True if `count` elements of `bytes` bytes, `stride` bytes apart, from `offset` on, lie in the view. Sizes
/// are below 2^53, so that sums do not overflow.
bool lies_in(const BufferView& view, std::uint64_t offset, std::uint64_t count, std::uint64_t stride,
             std::uint64_t bytes) {
  if (count == 0) return true;
  if (offset > view.byteLength || bytes > view.byteLength - offset) return false;
  return (view.byteLength - offset - bytes) / stride >= count - 1;
}

Checked check_dense(const Document& document, const std::string& name, const Accessor& accessor) {
  if (accessor.bufferView < 0) return {};
  const std::string view_name = label("buffer view", accessor.bufferView);
  if (const auto read = bytes_of_view(document, accessor.bufferView); !read)
    return malformed(name + ": " + read.error().what);
  const BufferView& view = at(document.bufferViews, accessor.bufferView);
  const std::uint64_t bytes = element_bytes(accessor);
  if (view.byteStride != 0 && view.byteStride < bytes)
    return malformed(name + ": the stride of its " + view_name + " (" + std::to_string(view.byteStride) +
                     ") is less than an element (" + std::to_string(bytes) + ")");
  if (!lies_in(view, accessor.byteOffset, accessor.count, view.byteStride ? view.byteStride : bytes, bytes))
    return malformed(name + " reads beyond its " + view_name);
  return {};
}

Checked check_sparse(const Document& document, const std::string& name, const Accessor& accessor) {
  const auto& sparse = accessor.sparse;
  if (!sparse.isSparse) return {};
  const auto component = static_cast<Component>(sparse.indices.componentType);
  const auto count = static_cast<std::uint64_t>(sparse.count);
  if (count == 0 || count > accessor.count)
    return malformed(name + ": has " + std::to_string(count) + " sparse elements, should have 1 to " +
                     std::to_string(accessor.count));
  if (component != Component::UInt8 && component != Component::UInt16 && component != Component::UInt32)
    return malformed(name + ": sparse indices should be unsigned integers");
  for (const int view : {sparse.indices.bufferView, sparse.values.bufferView})
    if (const auto read = bytes_of_view(document, view); !read)
      return malformed(name + ": its sparse part: " + read.error().what);
  const auto fits = [&](const auto& part, std::uint64_t bytes) {
    const auto offset = static_cast<std::uint64_t>(part.byteOffset);
    return lies_in(at(document.bufferViews, part.bufferView), offset, count, bytes, bytes);
  };
  if (!fits(sparse.indices, bytes_of(component)))
    return malformed(name + ": its sparse indices read beyond their buffer view");
  if (!fits(sparse.values, element_bytes(accessor)))
    return malformed(name + ": its sparse values read beyond their buffer view");
  const auto numbers = sparse_indices(document, accessor);
  const auto unordered = std::adjacent_find(numbers.begin(), numbers.end(), std::greater_equal<>());
  if (unordered != numbers.end() || numbers.back() >= accessor.count)
    return malformed(name + ": its sparse indices should grow and stay below " +
                     std::to_string(accessor.count));
  return {};
}

/// Whether all elements are finite.
Checked check_finite(const Document& document, const std::string& name, const Accessor& accessor) {
  std::optional<std::uint64_t> first;
  if (component_of(accessor) != Component::Float) return {};
  for_each_element(document, accessor, [&](std::uint64_t i, const std::uint8_t* bytes, auto) {
    for (std::uint64_t at = 0; at < element_bytes(accessor) && !first; at += sizeof(float))
      if (!std::isfinite(load<float>(bytes + at))) first = i;
  });
  if (!first) return {};
  return malformed(name + ": element " + std::to_string(*first) + " is not finite");
}

}  // namespace

Expected<ByteSpan> bytes_in_buffer(const Document& document, const std::string& name, int number,
                                   std::size_t offset, std::size_t bytes) {
  if (!points_into(document.buffers, number) || number < 0)
    return malformed(name + ": there is no " + label("buffer", number));
  const tinygltf::Buffer& buffer = at(document.buffers, number);
  const ByteSpan all = buffer.data;
  if (offset <= all.size() && bytes <= all.size() - offset) return all.subspan(offset, bytes);
  if (!buffer.name.empty()) return malformed(buffer.name);
  return malformed(name + " reads beyond its buffer (" + std::to_string(all.size()) + " bytes)");
}

Expected<ByteSpan> bytes_of_view(const Document& document, int index) {
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

Expected<const Accessor*> accessor_of(const Document& document, const std::string& user, int index,
                                      const Elements& elements, const std::string& fault) {
  const auto found = accessor_at(document, user, index);
  if (!found) return found;
  const Shape shape = shape_of(**found);
  if ((numbers_of(**found) & elements.numbers) != 0 && shape.columns == elements.columns &&
      shape.rows >= elements.least_rows && shape.rows <= elements.most_rows)
    return found;
  return malformed(user + " " + label("accessor", index) + " " + fault);
}

Expected<const Accessor*> attribute_of(const Document& document, const std::string& user, std::uint32_t index,
                                       const Elements& elements, std::optional<std::uint64_t> count,
                                       const char* what) {
  const auto found = accessor_of(document, user, static_cast<int>(index), elements,
                                 "has a type that this attribute cannot have");
  if (!found || (*found)->count == count.value_or((*found)->count)) return found;
  return malformed(user + " " + label("accessor", index) + " has " + std::to_string((*found)->count) +
                   " elements for " + std::to_string(*count) + " " + what);
}

template <int N>
std::vector<glm::vec<N, float>> read_vectors(const Document& document, Index index) {
  if (!index) return {};
  const Accessor& accessor = document.accessors[*index];
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
template std::vector<glm::vec<1, float>> read_vectors<1>(const Document&, Index);
template std::vector<glm::vec2> read_vectors<2>(const Document&, Index);
template std::vector<glm::vec3> read_vectors<3>(const Document&, Index);
template std::vector<glm::vec4> read_vectors<4>(const Document&, Index);

std::vector<glm::mat4> read_matrices(const Document& document, std::uint32_t index) {
  std::vector<glm::mat4> result(document.accessors[index].count, glm::mat4(0.0f));
  for_each_element(document, document.accessors[index],
                   [&](std::uint64_t i, const std::uint8_t* bytes, auto) {
                     std::memcpy(&result[i], bytes, sizeof result[i]);
                   });
  return result;
}

std::vector<float> read_scalars(const Document& document, std::uint32_t index) {
  std::vector<float> result;
  for (const auto& value : read_vectors<1>(document, index)) result.push_back(value.x);
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

void validate_accessors(Document& document) {
  Budget left(element_budget(document));
  for (std::size_t i = 0; i < document.accessors.size(); ++i) {
    Accessor& accessor = document.accessors[i];
    const std::string name = label("accessor", i);
    if (!accessor.name.empty()) continue;
    const Checked checked =
        check_dense(document, name, accessor)
            .and_then([&] {
              return left.take(accessor.count, name + ": " + std::to_string(accessor.count) +
                                                   " elements are more than a file of this size should have");
            })
            .and_then([&] { return check_sparse(document, name, accessor); })
            .and_then([&] { return check_finite(document, name, accessor); });
    if (!checked) accessor.name = checked.error().what;
    if (checked && accessor.bufferView >= 0 &&
        (at(document.bufferViews, accessor.bufferView).byteOffset + accessor.byteOffset) %
                bytes_of(component_of(accessor)) !=
            0)
      document.repairs.add(kReadAnyway, name + " is not aligned to its component type");
  }
}

}  // namespace farshade::gltf
