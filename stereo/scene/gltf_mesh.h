/// Triangles from a validated primitive.
#pragma once

#include "stereo/scene/gltf_document.h"
#include "stereo/scene/scene.h"

namespace farshade::gltf {

/// Strips and fans become triangles, triangles without area are left out, missing normals are those of the
/// faces (glTF 2.0 section 3.7.2.1: vertices are then no longer shared), texture coordinates get their
/// material's transform. Material and name are the caller's.
[[nodiscard]] farshade::Mesh mesh_from(const Document& document, const Primitive& primitive);

}  // namespace farshade::gltf
