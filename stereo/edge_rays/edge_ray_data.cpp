#include "stereo/edge_rays/edge_ray_data.h"

#include <algorithm>

#include "stereo/base/check.h"

namespace farshade {
namespace {

/// No fewer than caster_triangles finds.
std::uint64_t most_casters(const Scene& scene, const DrawPlan& plan) {
  std::uint64_t triangles = 0;
  for (std::size_t i = 0; i < scene.instances.size(); ++i)
    if (scene.instances[i].casts && !plan.moves[i])
      triangles += scene.meshes[scene.instances[i].mesh].triangles.size();
  return triangles;
}

/// The projection of the light buffer of each light, also of those that are off.
std::vector<LightShadowMaps> light_projections(const Scene& scene, std::vector<Light> lights) {
  for (Light& light : lights) light.on = true;
  std::vector<Point<Stage>> corners;
  for (int corner = 0; corner < 8; ++corner) corners.push_back({scene.bounds.corner(corner)});
  ShadowMapSettings settings;
  settings.side_px = FARSHADE_LIGHT_BUFFER_SIDE;
  settings.pcf_radius = 0;
  return shadow_map_views(lights, corners, settings).lights;
}

}  // namespace

std::size_t EdgeRayData::buffers() const {
  return static_cast<std::size_t>(std::ranges::count_if(
      lights, [](const Buffered& light) { return light.projection.view.kind != FARSHADE_MAP_NONE; }));
}

EdgeRayInput edge_ray_input(const Scene& scene, const DrawPlan& plan, std::uint64_t most_texels) {
  const std::uint64_t corners = 3 * most_casters(scene, plan) + 1;
  EdgeRayInput input;
  if (corners * sizeof(glm::vec4) + 1 <= kMostEdgeRayBytes && corners <= most_texels) {
    input.casters = caster_triangles(scene, plan);
    input.texels = caster_texels(scene, input.casters, kMostEdgeRayBytes, most_texels);
    const std::uint64_t words = (kMostEdgeRayBytes - input.texels.bytes()) / sizeof(std::uint32_t);
    input.most_words = std::min(words, most_texels);
  }
  const SceneState state = state_at(scene, {});
  const std::vector<LightShadowMaps> projections = light_projections(scene, state.light_set.lights);
  for (std::size_t i = 0; i < projections.size(); ++i) {
    input.lights.push_back({.light = state.light_set.lights[i],
                            .depths = list_depths(projections[i].view, input.casters),
                            .projection = projections[i]});
    if (scene.nodes[scene.lights[i].node].moving) input.lights[i].projection.view.kind = FARSHADE_MAP_NONE;
  }
  return input;
}

EdgeRayData without_buffers(const EdgeRayInput& input) {
  return {.origin = input.casters.origin, .texels = input.texels, .lights = input.lights};
}

EdgeRayData make_edge_ray_data(const EdgeRayInput& input, const std::stop_token& stop) {
  EdgeRayData data = without_buffers(input);
  std::uint64_t words_left = input.most_words;
  for (EdgeRayData::Buffered& light : data.lights) {
    MapView& view = light.projection.view;
    light.projection.first_layer = narrow<std::uint32_t>(data.words.size());
    std::optional<LightBuffer> made;
    if (view.kind != FARSHADE_MAP_NONE && words_left > 0) {
      made = make_light_buffer(view, input.casters, words_left, stop);
      words_left = made ? words_left - made->size() : 0;
    }
    if (made)
      data.words.insert(data.words.end(), made->begin(), made->end());
    else
      view.kind = FARSHADE_MAP_NONE;
  }
  return data;
}

}  // namespace farshade
