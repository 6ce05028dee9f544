/// Converts validated primitives to triangles, and what deforms the meshes of nodes: morph targets with their
/// weights, and skins.
#pragma once

#include "stereo/gltf/gltf_animation.h"

namespace farshade::gltf {

/// Converts strips and fans to triangles, removes triangles without area, and applies KHR_texture_transform.
/// If the primitive has no normals, each triangle gets its own vertices with the normal of its plane
/// (glTF 2.0 section 3.7.2.1). The caller sets material and name.
[[nodiscard]] farshade::Mesh mesh_from(const Document& document, const Primitive& primitive);

/// The same for a primitive that a rig deforms, with its deformable; influences only if `skinned`. Keeps
/// triangles without area, which may get some. Positions and normals are those before deformation.
[[nodiscard]] farshade::Mesh deformable_mesh_from(const Document& document, const Primitive& primitive,
                                                  bool skinned);

void remove_without_area(farshade::Mesh& mesh);

/// Whether the mesh of node `number` is deformed: by a skin, by weights other than 0, or by an animation of
/// weights.
[[nodiscard]] bool deforms(const Document& document, std::uint32_t number, const WeightTracks& tracks);

/// The rig of node `number`, which deforms its mesh. A joint outside of the drawn scene follows node `still`,
/// which should have no transform.
[[nodiscard]] Rig rig_of(const Document& document, std::uint32_t number, const std::vector<Index>& scene_node,
                         std::uint32_t still, const WeightTracks& tracks);

}  // namespace farshade::gltf
