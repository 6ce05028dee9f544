/// Mends a Document, so that the conversion needs no checks: what is wrong is left out, with a note in
/// Document::repairs. Afterwards every index that is left is in range, every accessor that is named lies
/// inside its buffer (64-bit arithmetic), every number is finite, the nodes form a forest of bounded depth,
/// and the keys of animations can be interpolated. Refuses files that exceed a limit, and nodes in a cycle.
#pragma once

#include <set>

#include "stereo/gltf/gltf.h"
#include "stereo/gltf/gltf_model.h"

namespace farshade::gltf {

/// A refusal names the object: "mesh 3 'chair', primitive 0: more vertices than ...". validate_accessors must
/// have been called.
[[nodiscard]] Checked validate(Document& document, const SceneLimits& limits);

/// Checks buffer views and accessors: ranges, sparse elements, finite floats, and a limit on the number of
/// elements (element_budget). The name of an accessor that cannot be read says why.
void validate_accessors(Document& document);

/// KHR_animation_pointer. Replaces the channels whose path is "pointer" by channels of the nodes and lights
/// to which they point (moves_light). All others are removed with a warning, and channels without a node
/// without one, as the specification asks.
void resolve_pointers(Document& document);

// The parts of validate(), in order: each part relies on the parts before it.

void validate_lights(Document& document);
/// Meshes with their attributes and vertex indices. Removes primitives that cannot be drawn.
[[nodiscard]] Checked validate_meshes(Document& document);
/// Nodes and scenes.
[[nodiscard]] Checked validate_nodes(Document& document, const SceneLimits& limits);
/// Skins, and the meshes that nodes deform.
[[nodiscard]] Checked validate_deformations(Document& document);
[[nodiscard]] Checked validate_animations(Document& document);
/// Refuses node hierarchies whose transforms, animated or not, reach further than double can represent well.
[[nodiscard]] Checked validate_reach(const Document& document);

/// `roots` and the nodes below them, parents before children. The nodes must be a forest (validate_nodes).
[[nodiscard]] std::vector<std::uint32_t> parents_first(const Document& document,
                                                       const std::vector<int>& roots);

/// The nodes of which an animation moves `path`, such as "scale".
[[nodiscard]] std::set<int> nodes_with_moving(const Document& document, std::string_view path);

/// The limit on the elements of all accessors together, and on the elements that all primitives read:
/// 2^22 + 8 * bytes of all buffers, at most 2^30. It bounds the work that a small hostile file can cause.
[[nodiscard]] std::uint64_t element_budget(const Document& document);

/// Calls `check_item(index, item)` for each item of `list`, up to the first fault.
template <class List, class Check>
[[nodiscard]] Checked check_each(List& list, Check check_item) {
  for (std::size_t i = 0; i < list.size(); ++i)
    if (Checked checked = check_item(i, list[i]); !checked) return checked;
  return {};
}

}  // namespace farshade::gltf
