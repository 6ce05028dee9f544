/// Deformed meshes: morph targets with the file's weights, and skins with the joints' poses at time 0. The
/// result stands still: it is a mesh like any other.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "stereo/math/spaces.h"
#include "stereo/scene/gltf_document.h"

namespace farshade::gltf {

/// What a node does to the vertices of its mesh. Empty: nothing.
struct Deformation {
  std::vector<double> weights;                          ///< of the morph targets
  std::vector<Affine<Stage, Object>> stage_from_bound;  ///< one per joint of the skin

  [[nodiscard]] bool is_none() const { return weights.empty() && stage_from_bound.empty(); }
};

/// `poses` are those of the document's nodes; a joint outside of the drawn scene has none, and does not move
/// vertices.
[[nodiscard]] Deformation deformation_of(const Document& document, const Node& node,
                                         const std::vector<std::optional<Affine<Stage, Object>>>& poses);

/// The vertices of a primitive, deformed. With a skin, they are in the stage. Without NORMAL, `normals` is
/// empty.
struct Vertices {
  std::vector<glm::vec3> positions, normals;
};
[[nodiscard]] Vertices vertices_of(const Document& document, const Primitive& primitive,
                                   const Deformation& deformation);

}  // namespace farshade::gltf
