/// Shadow map views: the projection of each light's shadow map. A point light has the six faces of a cube,
/// and so has a spot that is too wide for one perspective projection. Other spots have one perspective
/// projection that contains the outer cone. A directional light has a parallel projection of a box around the
/// scene. Pure; no device needed. (L. Williams, "Casting curved shadows on curved surfaces", SIGGRAPH 1978.)
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "shaders/shared.h"
#include "stereo/frame/view.h"
#include "stereo/scene/scene_state.h"
#include "stereo/shadow_maps/shadow_map_settings.h"

namespace farshade {

/// A spot with a wider outer cone uses a cube. In a wider projection, texels at the rim would be more than
/// four times as far apart as in the middle.
inline constexpr float kWidestWindow_rad = 1.05f;

/// The number of layers of a light's map: 6 or 1.
[[nodiscard]] std::uint32_t map_layers(LightKind kind, float outer_cone_rad);

/// The layers of the maps of a scene's lights, and where depth of instances that cannot move is kept.
struct MapLayers {
  std::uint32_t count = 0;  ///< even, because layers are drawn in pairs
  /// For each pair of layers, its pair in the image of kept depth. Empty if neither of the two lights can
  /// stand still while something moves.
  std::vector<std::optional<std::uint32_t>> kept_pair;
  std::uint32_t kept = 0;  ///< layers of the image of kept depth; even

  [[nodiscard]] std::uint64_t bytes(std::uint32_t side_px) const;
};

/// If kept depth does not fit into kMostShadowMapBytes with the maps, none is kept.
[[nodiscard]] MapLayers map_layers(const Scene& scene, const ShadowMapSettings& settings);

/// The projection of one layer: gpu::ShadowMapData in double and relative to the stage.
struct MapView {
  std::uint32_t kind = FARSHADE_MAP_NONE;
  glm::dvec3 right{0.0}, up{0.0}, ahead{0.0};
  Point<Stage> origin;
  glm::dvec2 texels{0.0};     ///< per unit
  double depth_per_m = 0.0;   ///< parallel only
  std::uint32_t side_px = 1;  ///< of the map
};

/// The projection of a cube face; the faces are +x, -x, +y, -y, +z, -z.
[[nodiscard]] MapView face_view(const MapView& cube, std::uint32_t face);

/// From the stage to Vulkan clip space. Depth is near / distance; in a parallel projection it runs from 1 at
/// the end nearest to the light to 0. With FARSHADE_MAP_NONE everything is clipped.
[[nodiscard]] glm::dmat4 clip_from_stage(const MapView& view);

struct LightShadowMaps {
  MapView view;  ///< without axes for a cube
  std::uint32_t first_layer = 0;
};

struct ShadowMapViews {
  std::vector<LightShadowMaps> lights;  ///< FARSHADE_MAP_NONE for a light that is off
  std::vector<glm::dmat4> layer_clip;   ///< clip_from_stage of each layer
};

/// `corners` are those of boxes that together contain the scene; if there are none, no light has a map. Each
/// map has a border as wide as the PCF filter, so that no comparison reads beyond the edge of a map or a cube
/// face.
[[nodiscard]] ShadowMapViews shadow_map_views(std::span<const Light> lights,
                                              std::span<const Point<Stage>> corners,
                                              const ShadowMapSettings& settings);

[[nodiscard]] gpu::ShadowMapData shadow_map_data(const StereoView& shown, const LightShadowMaps& map);

}  // namespace farshade
