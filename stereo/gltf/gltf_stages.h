/// The stages in which a file becomes a Scene, in order. After the validate_ functions, every index that is
/// left in the Document is in range, every accessor that is named lies inside its buffer (64-bit arithmetic),
/// every number is finite, the nodes form a forest of bounded depth, and the keys of animations can be
/// interpolated: the conversion needs no checks. Faults are mended by leaving out what is wrong, with a note
/// in Document::repairs. Refused are files that exceed a limit, and nodes in a cycle. A refusal names the
/// object: "mesh 3 'chair', primitive 0: more vertices than ...".
#pragma once

#include <set>

#include "stereo/gltf/gltf_files.h"
#include "stereo/gltf/gltf_model.h"
#include "stereo/scene/scene_choice.h"

namespace farshade::gltf {

/// Reads a Document from the JSON text of a file, and the buffers and images that it names. Those that are
/// named by a relative URI are read from `folder`. Refuses text that is not JSON, and versions and extensions
/// that cannot be read. A buffer that cannot be read as a whole says why in its name; of an image,
/// Document::unreadable says it. The nesting depth of the text must be bounded (check_json_depth).
[[nodiscard]] Expected<Document> read_document(const Container& container, SceneFolder& folder);

/// KHR_animation_pointer. Replaces the channels whose path is "pointer" by channels of the nodes and lights
/// to which they point (moves_light). All others are removed with a warning, and channels without a node
/// without one, as the specification asks.
void resolve_pointers(Document& document);

/// Compressed buffer views and meshes become plain ones, in buffers of their own: EXT_meshopt_compression
/// (meshoptimizer) and KHR_draco_mesh_compression. Everything after it reads accessors of plain bytes. A
/// damaged view says so in its name, a damaged primitive becomes an empty one.
///
/// A small hostile file must not make large ones. Sizes come from the JSON and from the header of the
/// compressed bytes; they are compared with the compressed size and with one budget for the file before
/// anything is allocated: 2^26 + 256 * bytes of all buffers. Draco needs the most: about 180 bytes for a
/// triangle, which it can compress to little more than one byte. Refuses what exceeds the budget.
[[nodiscard]] Checked decompress(Document& document);
/// The part of it for primitives with Draco meshes: their attributes and indices become accessors.
[[nodiscard]] Checked decompress_draco(Document& document, Budget& budget);
inline constexpr const char* kTooMuch = " decodes to more bytes than a file of this size should have";

/// Checks buffer views and accessors: ranges, sparse elements, finite floats, and a limit on the number of
/// elements (element_budget). The name of an accessor that cannot be read says why.
void validate_accessors(Document& document);

/// EXT_mesh_gpu_instancing: replaces the mesh of each node with instances by children that show it, one for
/// each instance. A node whose own accessors do not fit shows its mesh once. Refuses more instances than a
/// file of this size should have. Instances of scale 0 are left out.
[[nodiscard]] Checked expand_instances(Document& document);

/// Makes the chosen scene the default one, gives primitives the materials of the chosen variant, and removes
/// the animations that do not play. Refuses what is not in the file with a list of what is.
[[nodiscard]] Checked choose_scene(Document& document, const SceneChoice& choice);

// Each of these relies on those before it.

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

/// Finds the chosen camera in the default scene; without a choice, the first node whose name starts with
/// `camera:`, else the first one with a camera.
[[nodiscard]] Checked choose_camera(Document& document, const SceneChoice& choice);

/// Converts the default scene: its nodes, parents first, with their meshes and lights. Refuses scenes without
/// triangles, more lights than the limit, and geometry further than 1e9 m from the origin. Does not set name
/// and hash.
[[nodiscard]] Expected<Scene> convert(Document& document, const SceneLimits& limits);

// For several stages.

/// What can be chosen.
[[nodiscard]] FileContents contents_of(const Document& document);

/// `roots` and the nodes below them, parents before children. The nodes must be a forest (validate_nodes).
[[nodiscard]] std::vector<std::uint32_t> parents_first(const Document& document,
                                                       const std::vector<int>& roots);

/// The nodes of which an animation moves `path`, such as "scale".
[[nodiscard]] std::set<int> nodes_with_moving(const Document& document, std::string_view path);

/// Calls `check_item(index, item)` for each item of `list`, up to the first fault.
template <class List, class Check>
[[nodiscard]] Checked check_each(List& list, Check check_item) {
  for (std::size_t i = 0; i < list.size(); ++i)
    if (Checked checked = check_item(i, list[i]); !checked) return checked;
  return {};
}

}  // namespace farshade::gltf
