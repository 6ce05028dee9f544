#include "stereo/shadow_maps/shadow_map_views.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "stereo/base/check.h"

namespace farshade {
namespace {

/// Texels from the middle of a map to the border that PCF needs.
double reach_texels(const ShadowMapSettings& settings) {
  return 0.5 * settings.side_px - (settings.pcf_radius + 1);
}

/// Sets unit axes perpendicular to `ahead`.
void set_axes(const glm::dvec3& ahead, MapView& view) {
  const glm::dvec3 size = glm::abs(ahead);
  const glm::dvec3 aside = size.y <= size.x && size.y <= size.z ? glm::dvec3(0, 1, 0)
                           : size.x <= size.z                   ? glm::dvec3(1, 0, 0)
                                                                : glm::dvec3(0, 0, 1);
  view.ahead = ahead;
  view.right = glm::normalize(glm::cross(ahead, aside));
  view.up = glm::cross(view.right, ahead);
}

/// Fits a parallel projection to the box around `corners` along the light's axes. The origin is the centre of
/// the box's far side.
void fit(std::span<const Point<Stage>> corners, double reach, MapView& view) {
  constexpr double kMargin = 1e-3, kLeast_m = 1e-6;
  const glm::dvec3 about = corners[0].v;  // keeps precision far from the stage's origin
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

/// A light whose cone is animated keeps its map.
float widest_cone(const Light& light) {
  return std::max(light.outer_cone_rad, light.widest_cone_rad);
}

MapView view_of(const Light& light, std::span<const Point<Stage>> corners,
                const ShadowMapSettings& settings) {
  MapView view{.origin = light.position, .side_px = settings.side_px};
  const double reach = reach_texels(settings);
  if (!light.on || corners.empty()) return view;
  if (light.kind == LightKind::Directional) {
    view.kind = FARSHADE_MAP_PARALLEL;
    set_axes(light.direction.v, view);
    fit(corners, reach, view);
  } else if (map_layers(light.kind, widest_cone(light)) == 1) {
    view.kind = FARSHADE_MAP_WINDOW;
    set_axes(light.direction.v, view);
    view.texels = glm::dvec2(reach / std::tan(std::max(double{widest_cone(light)}, 1e-3)));
  } else {
    view.kind = FARSHADE_MAP_CUBE;
    view.texels = glm::dvec2(reach);
  }
  return view;
}

bool some_move(const Scene& scene, bool move) {
  return std::ranges::any_of(scene.instances, [&](const Instance& i) { return can_move(scene, i) == move; });
}

}  // namespace

std::uint32_t map_layers(LightKind kind, float outer_cone_rad) {
  const bool window = kind == LightKind::Spot && outer_cone_rad <= kWidestWindow_rad;
  return window || kind == LightKind::Directional ? 1 : 6;
}

std::uint64_t MapLayers::bytes(std::uint32_t side_px) const {
  return std::uint64_t{count + kept} * side_px * side_px * 4;
}

MapLayers map_layers(const Scene& scene, const ShadowMapSettings& settings) {
  std::vector<bool> fixed;  // for each layer
  for (const LightSource& light : scene.lights)
    fixed.resize(fixed.size() + map_layers(light.kind, light.outer_cone_rad),
                 !scene.nodes[light.node].moving);
  fixed.resize(std::max<std::size_t>(fixed.size() + fixed.size() % 2, 2));
  MapLayers layers;
  layers.count = narrow<std::uint32_t>(fixed.size());
  layers.kept_pair.resize(layers.count / 2);
  if (settings.redraw == Redraw::Always || !some_move(scene, true) || !some_move(scene, false)) return layers;
  MapLayers with_kept = layers;
  for (std::size_t pair = 0; pair < layers.kept_pair.size(); ++pair) {
    if (!fixed[2 * pair] && !fixed[2 * pair + 1]) continue;
    with_kept.kept_pair[pair] = with_kept.kept / 2;
    with_kept.kept += 2;
  }
  return with_kept.bytes(settings.side_px) <= kMostShadowMapBytes ? with_kept : layers;
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
  glm::dmat4 rows(0.0);  // as rows; w = -1 clips everything
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
                                const ShadowMapSettings& settings) {
  ShadowMapViews views;
  for (const Light& light : lights) {
    const LightShadowMaps map{view_of(light, corners, settings),
                              static_cast<std::uint32_t>(views.layer_clip.size())};
    const std::uint32_t layers = map_layers(light.kind, widest_cone(light));
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

Expected<std::uint64_t> shadow_map_bytes(const Scene& scene, const ShadowMapSettings& settings) {
  const auto number = [](std::uint64_t n) { return std::to_string(n); };
  if (settings.side_px < kLeastMapSide_px || settings.side_px > kMostMapSide_px)
    return fail(Fault::OutOfRange, "a shadow map must have " + number(kLeastMapSide_px) + " to " +
                                       number(kMostMapSide_px) + " texels a side, not " +
                                       number(settings.side_px));
  if (settings.pcf_radius > kMostPcfRadius)
    return fail(Fault::OutOfRange, "the PCF radius must be 0 to " + number(kMostPcfRadius) + " texels, not " +
                                       number(settings.pcf_radius));
  const auto bytes_at = [&](std::uint32_t side) {
    ShadowMapSettings at = settings;
    at.side_px = side;
    return map_layers(scene, at).bytes(side);
  };
  if (bytes_at(settings.side_px) <= kMostShadowMapBytes) return bytes_at(settings.side_px);
  std::uint32_t side = settings.side_px;
  while (bytes_at(side) > kMostShadowMapBytes) side /= 2;
  return fail(Fault::Unavailable,
              "shadow maps of " + number(scene.lights.size()) + " lights with " + number(settings.side_px) +
                  " texels a side take " + number(bytes_at(settings.side_px) >> 20) + " MiB, and " +
                  number(kMostShadowMapBytes >> 20) + " are allowed: " + number(side) + " texels would do");
}

}  // namespace farshade
