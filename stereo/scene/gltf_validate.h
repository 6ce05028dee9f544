/// The pass that makes a Document trustworthy: after it, every index points at something, every accessor lies
/// inside its buffer (64-bit arithmetic), every number is finite, the nodes are a forest of bounded depth
/// with invertible transforms, and animations have keys that can be interpolated. What is converted later
/// needs no checks.
#pragma once

#include "stereo/scene/gltf.h"
#include "stereo/scene/gltf_document.h"

namespace farshade::gltf {

/// The first fault found, named: "mesh 3 'chair', primitive 0: POSITION accessor 17 ...".
[[nodiscard]] Checked validate(const Document& document, const SceneLimits& limits);

// Its parts, in the order in which they may rely on each other.

/// Buffer views, accessors (ranges, sparse parts, finite floats) and that accessors do not claim far more
/// elements than there are bytes.
[[nodiscard]] Checked validate_accessors(const Document& document);
/// Meshes with their attributes and vertex indices.
[[nodiscard]] Checked validate_meshes(const Document& document);
/// Textures, materials and lights.
[[nodiscard]] Checked validate_looks(const Document& document);
/// Nodes, scenes and animations.
[[nodiscard]] Checked validate_nodes(const Document& document, const SceneLimits& limits);
[[nodiscard]] Checked validate_animations(const Document& document);
/// That no pose of the animated hierarchy carries anything further than numbers can follow.
[[nodiscard]] Checked validate_reach(const Document& document);

/// The nodes below `roots`, parents before children. `roots` of a forest (validate_nodes).
[[nodiscard]] std::vector<std::uint32_t> parents_first(const Document& document,
                                                       const std::vector<std::uint32_t>& roots);

/// How many elements accessors, and the primitives that read them, may claim in total:
[[nodiscard]] std::uint64_t element_budget(const Document& document);

/// Applies `check_item(index, item)` to each of `list`, up to the first fault.
template <class List, class Check>
[[nodiscard]] Checked check_each(const List& list, Check check_item) {
  for (std::size_t i = 0; i < list.size(); ++i)
    if (Checked checked = check_item(i, list[i]); !checked) return checked;
  return {};
}

/// Whether an optional index is absent or points into `list`.
template <class List>
[[nodiscard]] bool points_into(const List& list, Index index) {
  return !index || *index < list.size();
}

}  // namespace farshade::gltf
