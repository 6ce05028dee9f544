/// EXT_mesh_gpu_instancing: each instance becomes a node of its own.
#pragma once

#include "stereo/gltf/gltf_model.h"

namespace farshade::gltf {

/// Replaces the mesh of each node with instances by children that show it, one for each instance. Accessors
/// must have been validated; a node whose own do not fit shows its mesh once. Refuses more instances than a
/// file of this size should have. Instances of scale 0 are left out.
[[nodiscard]] Checked expand_instances(Document& document);

}  // namespace farshade::gltf
