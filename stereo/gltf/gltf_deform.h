/// What deforms the meshes of a glTF file: morph targets with their weights, and skins.
#pragma once

#include <map>

#include "stereo/gltf/gltf_model.h"
#include "stereo/scene/scene.h"

namespace farshade::gltf {

/// The animated weights of morph targets, by the document's nodes.
using WeightTracks = std::map<std::uint32_t, WeightTrack>;

/// Weights beyond this are cut off.
inline constexpr double kMostWeight = 1e6;

/// Whether the mesh of node `number` is deformed: by a skin, by weights other than 0, or by an animation of
/// weights.
[[nodiscard]] bool deforms(const Document& document, const Node& node, std::uint32_t number,
                           const WeightTracks& tracks);

/// The rig of node `number`, which deforms its mesh. A joint outside of the drawn scene follows node `still`,
/// which should have no transform.
[[nodiscard]] Rig rig_of(const Document& document, std::uint32_t number, const std::vector<Index>& scene_node,
                         std::uint32_t still, const WeightTracks& tracks);

/// The vertices of a primitive and what they follow. Influences only if `skinned`. Normals may
/// have any length.
[[nodiscard]] Deformable deformable_of(const Document& document, const Primitive& primitive, bool skinned);

}  // namespace farshade::gltf
