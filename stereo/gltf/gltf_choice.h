/// Applies a SceneChoice to a Document. What is not in the file is refused with a list of what is.
#pragma once

#include "stereo/gltf/gltf_model.h"
#include "stereo/scene/scene.h"
#include "stereo/scene/scene_choice.h"

namespace farshade::gltf {

/// Makes the chosen scene the default one, gives primitives the materials of the chosen variant, and removes
/// the animations that do not play.
[[nodiscard]] Checked choose_scene(Document& document, const SceneChoice& choice);

/// Finds the chosen camera in the default scene. The document must be valid.
[[nodiscard]] Checked choose_camera(Document& document, const SceneChoice& choice);

/// What can be chosen. The document must be valid, and its default scene be there.
[[nodiscard]] FileContents contents_of(const Document& document);

/// The nodes of the default scene, parents first, that carry a camera or whose names begin with `camera:`.
[[nodiscard]] std::vector<std::uint32_t> camera_nodes(const Document& document);

}  // namespace farshade::gltf
