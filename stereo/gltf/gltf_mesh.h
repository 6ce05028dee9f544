/// Converts a validated primitive to triangles.
#pragma once

#include "stereo/gltf/gltf_deform.h"
#include "stereo/scene/scene.h"

namespace farshade::gltf {

/// Converts strips and fans to triangles, removes triangles without area, and applies KHR_texture_transform.
/// If the primitive has no normals, each triangle gets its own vertices with the normal of its plane
/// (glTF 2.0 section 3.7.2.1). The caller sets material and name.
[[nodiscard]] farshade::Mesh mesh_from(const Document& document, const Primitive& primitive);

/// The same for a primitive that a rig deforms, with its deformable. Keeps triangles without area, which may
/// get some. Positions and normals are those before deformation.
[[nodiscard]] farshade::Mesh deformable_mesh_from(const Document& document, const Primitive& primitive,
                                                  bool skinned);

void remove_without_area(farshade::Mesh& mesh);

}  // namespace farshade::gltf
