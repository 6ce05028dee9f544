#include "stereo/draw/shadow_map_views.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace farshade {
namespace {

/// Texels from a map's middle to where what it has to see ends.
double reach_texels(const ShadowMapSettings& wish) {
  return 0.5 * wish.side_px - (wish.pcf_radius + 1);
}

/// Axes about `ahead`, unit.
void set_axes(const glm::dvec3& ahead, MapView& view) {
  const glm::dvec3 size = glm::abs(ahead);
  const glm::dvec3 aside = size.y <= size.x && size.y <= size.z ? glm::dvec3(0, 1, 0)
                           : size.x <= size.z                   ? glm::dvec3(1, 0, 0)
                                                                : glm::dvec3(0, 0, 1);
  view.ahead = ahead;
  view.right = glm::normalize(glm::cross(ahead, aside));
  view.up = glm::cross(view.right, ahead);
}

/// The box about `corners` along the light's axes: its middle on the far side is the origin.
void fit(std::span<const Point<Stage>> corners, double reach, MapView& view) {
  constexpr double kMargin = 1e-3, kLeast_m = 1e-6;
  const glm::dvec3 about = corners[0].v;  // so that nothing is lost far from the stage's origin
  glm::dvec3 low(0.0), high(0.0);
  for (const Point<Stage>& corner : corners) {
    const glm::dvec3 d = corner.v - about,
                     p(glm::dot(d, view.right), glm::dot(d, view.up), glm::dot(d, view.ahead));
    low = glm::min(low, p), high = glm::max(high, p);
  }
  const glm::dvec3 half = glm::max((high - low) * (0.5 + kMargin), kLeast_m);
  const glm::dvec3 middle = (low + high) * 0.5;
  view.origin = {about + view.right * middle.x + view.up * middle.y + view.ahead * (middle.z + half.z)};
  view.texels = glm::dvec2(reach) / glm::dvec2(half);
  view.depth_per_m = 0.5 / half.z;
}

MapView view_of(const Light& light, std::span<const Point<Stage>> corners, const ShadowMapSettings& wish) {
  MapView view{.origin = light.position, .side_px = wish.side_px};
  const double reach = reach_texels(wish);
  if (!light.on || corners.empty()) return view;
  if (light.kind == LightKind::Directional) {
    view.kind = FARSHADE_MAP_PARALLEL;
    set_axes(light.direction.v, view);
    fit(corners, reach, view);
  } else if (map_layers(light.kind, light.outer_cone_rad) == 1) {
    view.kind = FARSHADE_MAP_WINDOW;
    set_axes(light.direction.v, view);
    view.texels = glm::dvec2(reach / std::tan(std::max(double{light.outer_cone_rad}, 1e-3)));
  } else {
    view.kind = FARSHADE_MAP_CUBE;
    view.texels = glm::dvec2(reach);
  }
  return view;
}

}  // namespace

std::uint32_t map_layers(LightKind kind, float outer_cone_rad) {
  const bool window = kind == LightKind::Spot && outer_cone_rad <= kWidestWindow_rad;
  return window || kind == LightKind::Directional ? 1 : 6;
}

MapView face_view(const MapView& cube, std::uint32_t face) {
  constexpr glm::dvec3 kX(1, 0, 0), kY(0, 1, 0), kZ(0, 0, 1);
  MapView view = cube;
  view.kind = FARSHADE_MAP_WINDOW;
  const std::uint32_t axis = face / 2;
  view.right = axis == 0 ? kZ : kX;
  view.up = axis == 1 ? kZ : kY;
  view.ahead = (axis == 0 ? kX : axis == 1 ? kY : kZ) * (face % 2 == 0 ? 1.0 : -1.0);
  return view;
}

glm::dmat4 clip_from_stage(const MapView& view) {
  glm::dmat4 rows(0.0);  // as rows; w of a view of no kind is -1: behind it
  rows[3].w = -1.0;
  if (view.kind == FARSHADE_MAP_NONE) return rows;
  const auto row = [&](const glm::dvec3& axis) { return glm::dvec4(axis, -glm::dot(axis, view.origin.v)); };
  const glm::dvec2 scale = view.texels * (2.0 / view.side_px);
  rows[0] = scale.x * row(view.right);
  rows[1] = -scale.y * row(view.up);  // rows of texels run down
  const bool parallel = view.kind == FARSHADE_MAP_PARALLEL;
  rows[2] = parallel ? -view.depth_per_m * row(view.ahead) : glm::dvec4(0, 0, 0, kNearPlane_m);
  rows[3] = parallel ? glm::dvec4(0, 0, 0, 1) : row(view.ahead);
  return glm::transpose(rows);
}

ShadowMapViews shadow_map_views(std::span<const Light> lights, std::span<const Point<Stage>> corners,
                                const ShadowMapSettings& wish) {
  ShadowMapViews views;
  for (const Light& light : lights) {
    const LightShadowMaps map{view_of(light, corners, wish),
                              static_cast<std::uint32_t>(views.layer_clip.size())};
    const std::uint32_t layers = map_layers(light.kind, light.outer_cone_rad);
    for (std::uint32_t layer = 0; layer < layers; ++layer)
      views.layer_clip.push_back(
          clip_from_stage(map.view.kind == FARSHADE_MAP_CUBE ? face_view(map.view, layer) : map.view));
    views.lights.push_back(map);
  }
  return views;
}

gpu::ShadowMapData shadow_map_data(const StereoView& shown, const LightShadowMaps& map) {
  gpu::ShadowMapData data{.right = glm::vec4(map.view.right, map.view.texels.x),
                          .up = glm::vec4(map.view.up, map.view.texels.y),
                          .ahead = glm::vec4(map.view.ahead, map.view.depth_per_m),
                          .origin = {},
                          .place = {map.view.kind, map.first_layer, 0, 0}};
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    data.origin[eye] = glm::vec4(map.view.origin.v - shown[eye].stage_from_eye.translation, 0.0);
  return data;
}

Expected<std::uint64_t> shadow_map_bytes(const Scene& scene, const ShadowMapSettings& wish) {
  const auto number = [](std::uint64_t n) { return std::to_string(n); };
  if (wish.side_px < kLeastMapSide_px || wish.side_px > kMostMapSide_px)
    return fail(Fault::OutOfRange, "a shadow map has " + number(kLeastMapSide_px) + " to " +
                                       number(kMostMapSide_px) + " texels a side, not " +
                                       number(wish.side_px));
  if (wish.pcf_radius > kMostPcfRadius)
    return fail(Fault::OutOfRange, "shadows are filtered over 0 to " + number(kMostPcfRadius) +
                                       " texels, not " + number(wish.pcf_radius));
  std::uint64_t layers = 0;
  for (const LightSource& light : scene.lights) layers += map_layers(light.kind, light.outer_cone_rad);
  layers += layers % 2;  // they are drawn in pairs
  const auto bytes_at = [&](std::uint64_t side) { return layers * side * side * 4; };
  if (bytes_at(wish.side_px) <= kMostShadowMapBytes) return bytes_at(wish.side_px);
  std::uint64_t side = wish.side_px;
  while (bytes_at(side) > kMostShadowMapBytes) side /= 2;
  return fail(Fault::Unavailable,
              "shadow maps of " + number(scene.lights.size()) + " lights with " + number(wish.side_px) +
                  " texels a side take " + number(bytes_at(wish.side_px) >> 20) + " MiB, and " +
                  number(kMostShadowMapBytes >> 20) + " are allowed: " + number(side) + " texels would do");
}

}  // namespace farshade
