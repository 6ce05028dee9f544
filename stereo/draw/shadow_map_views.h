/// Shadow map views: how each light sees the scene. A point light looks through the six faces of a cube, as
/// does a spot too wide for one window; a spot through a window that holds its outer cone; a directional
/// light along its direction, at a box that holds the scene. Pure; no device needed. (L. Williams, "Casting
/// curved shadows on curved surfaces", SIGGRAPH 1978.)
#pragma once

#include <span>

#include "shaders/shared.h"
#include "stereo/draw/shadow_map_settings.h"
#include "stereo/frame/view.h"
#include "stereo/scene/scene_state.h"

namespace farshade {

/// A spot whose outer cone is wider than this takes a cube: near the rim of a wider window texels would be
/// more than four times as far apart as in its middle.
inline constexpr float kWidestWindow_rad = 1.05f;

/// Layers of a light's map: 6 or 1.
[[nodiscard]] std::uint32_t map_layers(LightKind kind, float outer_cone_rad);

/// How one layer sees: as gpu::ShadowMapData has it, in double and in the stage.
struct MapView {
  std::uint32_t kind = FARSHADE_MAP_NONE;
  glm::dvec3 right{0.0}, up{0.0}, ahead{0.0};
  Point<Stage> origin;
  glm::dvec2 texels{0.0};     ///< per unit
  double depth_per_m = 0.0;   ///< parallel only
  std::uint32_t side_px = 1;  ///< of the map
};

/// Of a cube's face: +x, -x, +y, -y, +z, -z.
[[nodiscard]] MapView face_view(const MapView& cube, std::uint32_t face);

/// Vulkan clip space from the stage: depth near / distance as everywhere, parallel: from 1 nearest the light
/// to 0. A view of no kind sees nothing.
[[nodiscard]] glm::dmat4 clip_from_stage(const MapView& view);

struct LightShadowMaps {
  MapView view;  ///< a cube's has no axes
  std::uint32_t first_layer = 0;
};

struct ShadowMapViews {
  std::vector<LightShadowMaps> lights;  ///< one a light; of no kind where it is off
  std::vector<glm::dmat4> layer_clip;   ///< clip_from_stage of each layer
};

/// `corners`: of boxes that together hold the scene; without any there is nothing to see. Around all that a
/// map has to see it leaves as many texels as PCF reaches, so that no comparison is made beyond a map's edge
/// or across a cube's.
[[nodiscard]] ShadowMapViews shadow_map_views(std::span<const Light> lights,
                                              std::span<const Point<Stage>> corners,
                                              const ShadowMapSettings& wish);

[[nodiscard]] gpu::ShadowMapData shadow_map_data(const StereoView& shown, const LightShadowMaps& map);

}  // namespace farshade
