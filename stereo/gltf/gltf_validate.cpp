#include "stereo/gltf/gltf_accessor.h"
#include "stereo/gltf/gltf_stages.h"

namespace farshade::gltf {
namespace {

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

}  // namespace

std::uint64_t element_budget(const Document& document) {
  return std::min((std::uint64_t{1} << 22) + 8 * buffer_bytes(document), std::uint64_t{1} << 30);
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

Checked validate(Document& document, const SceneLimits& limits) {
  validate_lights(document);
  return validate_meshes(document)
      .and_then([&] { return validate_nodes(document, limits); })
      .and_then([&] { return validate_deformations(document); })
      .and_then([&] { return validate_animations(document); })
      .and_then([&] { return validate_reach(document); });
}

}  // namespace farshade::gltf
