/// Parts of a deformable mesh. Each part is a mesh and an instance of its own, so small that one affine
/// transform tells well enough how it moved: everything that follows an instance's motion then works for
/// deformed meshes.
#pragma once

#include "stereo/scene/deform.h"

namespace farshade {

/// A part has at most so many triangles.
inline constexpr std::size_t kPartTriangles = 256;

/// Sets positions and normals to those under `pose`, and turns triangles over whose skin mirrors them.
void pose_at_start(const RigPose& pose, Mesh& mesh);

/// The parts of a mesh with a deformable; one if it is small. Their triangles lie close together before
/// deformation. Vertices at borders are in every part that uses them.
[[nodiscard]] std::vector<Mesh> parts_of(Mesh mesh);

}  // namespace farshade
