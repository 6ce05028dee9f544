#include "stereo/scene/gltf_validate.h"

#include <cmath>
#include <cstring>

#include "stereo/scene/gltf_accessor.h"

namespace farshade::gltf {
namespace {

Checked check_view(const Document& document, std::size_t index, const BufferView& view) {
  const std::string name = label("buffer view", index);
  if (view.buffer >= document.buffers.size())
    return malformed(name + ": there is no " + label("buffer", view.buffer));
  const std::uint64_t size = document.buffers[view.buffer].size();
  if (view.offset > size || view.bytes > size - view.offset)
    return malformed(name + " reads beyond its buffer (" + std::to_string(size) + " bytes)");
  return {};
}

/// True if `count` elements of `bytes` bytes, `stride` bytes apart, from `offset` on, lie in the view. Sizes
/// are below 2^53, so that sums do not overflow.
bool lies_in(const BufferView& view, std::uint64_t offset, std::uint64_t count, std::uint64_t stride,
             std::uint64_t bytes) {
  if (count == 0) return true;
  if (offset > view.bytes || bytes > view.bytes - offset) return false;
  return (view.bytes - offset - bytes) / stride >= count - 1;
}

Checked check_dense(const Document& document, const std::string& name, const Accessor& accessor) {
  if (!accessor.view) return {};
  if (*accessor.view >= document.views.size())
    return malformed(name + ": there is no " + label("buffer view", *accessor.view));
  const BufferView& view = document.views[*accessor.view];
  const std::uint64_t bytes = accessor.element_bytes();
  if (view.stride != 0 && view.stride < bytes)
    return malformed(name + ": the stride of its " + label("buffer view", *accessor.view) + " (" +
                     std::to_string(view.stride) + ") is less than an element (" + std::to_string(bytes) +
                     ")");
  if ((view.offset + accessor.offset) % bytes_of(accessor.component) != 0)
    return malformed(name + " is not aligned to its component type");
  if (!lies_in(view, accessor.offset, accessor.count, view.stride ? view.stride : bytes, bytes))
    return malformed(name + " reads beyond its " + label("buffer view", *accessor.view));
  return {};
}

Checked check_sparse(const Document& document, const std::string& name, const Accessor& accessor) {
  if (!accessor.sparse) return {};
  const Sparse& sparse = *accessor.sparse;
  const auto component = sparse.index_component;
  if (sparse.count == 0 || sparse.count > accessor.count)
    return malformed(name + ": has " + std::to_string(sparse.count) + " sparse elements, should have 1 to " +
                     std::to_string(accessor.count));
  if (component != Component::UInt8 && component != Component::UInt16 && component != Component::UInt32)
    return malformed(name + ": sparse indices should be unsigned integers");
  if (sparse.index_view >= document.views.size() || sparse.value_view >= document.views.size())
    return malformed(name + ": its sparse part names a buffer view that is not there");
  const std::uint64_t index_bytes = bytes_of(component), value_bytes = accessor.element_bytes();
  if (!lies_in(document.views[sparse.index_view], sparse.index_offset, sparse.count, index_bytes,
               index_bytes))
    return malformed(name + ": its sparse indices read beyond their buffer view");
  if (!lies_in(document.views[sparse.value_view], sparse.value_offset, sparse.count, value_bytes,
               value_bytes))
    return malformed(name + ": its sparse values read beyond their buffer view");
  const auto numbers = sparse_indices(document, sparse);
  const auto unordered = std::adjacent_find(numbers.begin(), numbers.end(), std::greater_equal<>());
  if (unordered != numbers.end() || numbers.back() >= accessor.count)
    return malformed(name + ": its sparse indices should grow and stay below " +
                     std::to_string(accessor.count));
  return {};
}

bool is_finite_element(const std::uint8_t* bytes, std::uint32_t components) {
  for (std::uint32_t c = 0; c < components; ++c) {
    float value = 0;
    std::memcpy(&value, bytes + c * sizeof value, sizeof value);
    if (!std::isfinite(value)) return false;
  }
  return true;
}

Checked check_finite(const Document& document, const std::string& name, const Accessor& accessor) {
  if (accessor.component != Component::Float) return {};
  const std::uint32_t components = accessor.rows * accessor.columns;
  const ElementRun run = elements_of(document, accessor);
  if (run.first)
    for (std::uint64_t i = 0; i < accessor.count; ++i)
      if (!is_finite_element(run.first + i * run.stride, components))
        return malformed(name + ": element " + std::to_string(i) + " is not finite");
  if (!accessor.sparse) return {};
  const BufferView& view = document.views[accessor.sparse->value_view];
  const auto* values = document.buffers[view.buffer].data() + view.offset + accessor.sparse->value_offset;
  for (std::uint64_t i = 0; i < accessor.sparse->count; ++i)
    if (!is_finite_element(values + i * accessor.element_bytes(), components))
      return malformed(name + ": sparse element " + std::to_string(i) + " is not finite");
  return {};
}

}  // namespace

std::uint64_t element_budget(const Document& document) {
  std::uint64_t bytes = 0;
  for (const auto& buffer : document.buffers) bytes += buffer.size();
  return std::min((std::uint64_t{1} << 22) + 8 * bytes, std::uint64_t{1} << 30);
}

Checked validate_accessors(const Document& document) {
  auto views = check_each(
      document.views, [&](std::size_t i, const BufferView& view) { return check_view(document, i, view); });
  if (!views) return views;
  std::uint64_t left = element_budget(document);
  return check_each(document.accessors, [&](std::size_t i, const Accessor& accessor) -> Checked {
    const std::string name = label("accessor", i);
    if (bytes_of(accessor.component) == 0)
      return malformed(name + ": unknown component type " +
                       std::to_string(static_cast<std::uint32_t>(accessor.component)));
    if (accessor.count > left)
      return fail(Fault::OutOfRange, name + ": " + std::to_string(accessor.count) +
                                         " elements are more than a file of this size should have");
    left -= accessor.count;
    return check_dense(document, name, accessor)
        .and_then([&] { return check_sparse(document, name, accessor); })
        .and_then([&] { return check_finite(document, name, accessor); });
  });
}

Checked validate(const Document& document, const SceneLimits& limits) {
  return validate_materials(document)
      .and_then([&] { return validate_meshes(document); })
      .and_then([&] { return validate_nodes(document, limits); })
      .and_then([&] { return validate_deformations(document); })
      .and_then([&] { return validate_animations(document); })
      .and_then([&] { return validate_reach(document); });
}

}  // namespace farshade::gltf
