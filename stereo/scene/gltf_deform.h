/// Deformed meshes: morph targets with the file's weights, and skins with the joints' poses at time 0. The
/// result stands still: it is a mesh like any other.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "stereo/math/spaces.h"
#include "stereo/scene/gltf_document.h"

namespace farshade::gltf {

using Poses = std::vector<std::optional<Affine<Stage, Object>>>;  ///< of the document's nodes

/// For each joint of a skin, what it does to a vertex. A joint without a pose, outside of the drawn scene,
/// does nothing.
[[nodiscard]] std::vector<Affine<Stage, Object>> joints_of(const Document& document, const Skin& skin,
                                                           const Poses& poses);

/// What a node does to the vertices of its mesh. Empty: nothing.
struct Deformation {
  std::span<const double> weights;                  ///< of the morph targets
  std::span<const Affine<Stage, Object>> joints{};  ///< joints_of its skin

  [[nodiscard]] bool is_none() const { return weights.empty() && joints.empty(); }
};

/// The weights of the node, else of its mesh; none if all are 0 or the mesh has no targets.
[[nodiscard]] std::span<const double> weights_of(const Document& document, const Node& node);

/// The vertices of a primitive, deformed. With a skin, they are in the stage. Without NORMAL, `normals` is
/// empty.
struct Vertices {
  std::vector<glm::vec3> positions, normals;
  std::vector<bool> mirrored;  ///< their joints turn triangles over; empty without a skin
};
[[nodiscard]] Vertices vertices_of(const Document& document, const Primitive& primitive,
                                   const Deformation& deformation);

}  // namespace farshade::gltf
