#include "stereo/plan/scene_plan.h"

#include <algorithm>

#include "stereo/base/check.h"
#include "stereo/plan/light_reach.h"

namespace farshade {
namespace {

bool is_white(const std::vector<glm::u8vec4>& colors) {
  return std::ranges::all_of(colors, [](const glm::u8vec4& color) { return color == glm::u8vec4(255); });
}

SurfaceNeeds needs_of(const Scene& scene, const Mesh& mesh) {
  const Material& material = scene.materials[mesh.material];
  return {.texture = material.texture.has_value() && !mesh.uvs.empty(),
          .vertex_color = !is_white(mesh.colors),
          .alpha_test = material.alpha_cutoff.has_value(),
          .back_test = !material.double_sided};
}

bool moves(const Scene& scene, std::uint32_t node) {
  return scene.nodes[node].moving;
}

bool anything_seen_moves(const Scene& scene) {
  return std::ranges::any_of(scene.instances, [&](const Instance& i) { return can_move(scene, i); });
}

LightStatus status_of(const Scene& scene, const LightSource& source, Light light) {
  if (source.intensity == glm::vec3(0.0f)) return LightStatus::Dark;
  if (moves(scene, source.node) || anything_seen_moves(scene)) return LightStatus::Casts;
  light.range_m = source.range_m.value_or(0.0f);  // the largest, if it is animated
  light.outer_cone_rad = source.outer_cone_rad;
  return may_reach(light, scene.bounds) ? LightStatus::Casts : LightStatus::OutOfReach;
}

std::vector<LightStatus> statuses_of(const Scene& scene, const SessionNeeds& needs) {
  std::vector<LightStatus> statuses(scene.lights.size(), LightStatus::Casts);
  if (needs.all_lights || needs.kind == PlanKind::Everything) return statuses;
  const LightSet lights = state_at(scene, Time{}).light_set;
  for (std::size_t i = 0; i < statuses.size(); ++i)
    statuses[i] = status_of(scene, scene.lights[i], lights.lights[i]);
  return statuses;
}

/// Leaves nothing out, whatever the scene and the session need.
void turn_everything_on(ScenePlan& plan) {
  for (std::vector<SurfaceNeeds>* surfaces : {&plan.trace.surfaces, &plan.draw.surfaces})
    std::ranges::fill(*surfaces, SurfaceNeeds{true, true, true, true});
  plan.trace.moves.assign(plan.trace.moves.size(), true);
  plan.draw.moves = plan.trace.moves;
  plan.trace.mask.least_word_bytes = plan.draw.mask.least_word_bytes = 4;
  plan.trace.skips_rays = plan.trace.shares_views = plan.draw.builds_late = false;
  plan.draw.detail_px = 0;
  plan.draw.lights_move = plan.draw.ranges_and_cones = plan.draw.other_eye = plan.draw.depth_pass =
      plan.draw.cube_mask = true;
}

}  // namespace

bool DrawPlan::anything_moves() const {
  return lights_move || std::ranges::find(moves, true) != moves.end();
}

ScenePlan plan_for(const Scene& scene, const SessionNeeds& needs) {
  ScenePlan plan{.kind = needs.kind, .lights = statuses_of(scene, needs), .trace = {}, .draw = {}};
  const auto casting = narrow<std::uint32_t>(std::ranges::count(plan.lights, LightStatus::Casts));
  plan.server = casting > 0;
  plan.trace.mask = plan.draw.mask = {.lights = casting};
  for (const Mesh& mesh : scene.meshes) plan.trace.surfaces.push_back(needs_of(scene, mesh));
  for (const Instance& instance : scene.instances) plan.trace.moves.push_back(can_move(scene, instance));
  plan.draw.surfaces = plan.trace.surfaces;
  plan.draw.moves = plan.trace.moves;
  plan.draw.lights_move = plan.draw.ranges_and_cones = false;
  for (std::size_t i = 0; i < plan.lights.size(); ++i) {
    if (plan.lights[i] != LightStatus::Casts) continue;
    const LightSource& light = scene.lights[i];
    plan.draw.lights_move |= moves(scene, light.node) || changes_reach(light);
    plan.draw.ranges_and_cones |= light.kind == LightKind::Spot || light.range_m.value_or(0) > 0;
  }
  plan.draw.other_eye = needs.two_views && needs.reprojects;
  plan.draw.depth_pass = needs.reprojects;
  plan.draw.cube_mask = needs.cube_mask && needs.reprojects;
  plan.draw.detail_px = needs.detail_px;
  plan.draw.ambient = scene.ambient;
  if (needs.kind == PlanKind::Everything) turn_everything_on(plan);
  return plan;
}

PlannedScene plan_scene(Scene scene, const SessionNeeds& needs) {
  ScenePlan plan = plan_for(scene, needs);
  std::size_t light = 0;
  std::erase_if(scene.lights, [&](const LightSource&) { return plan.lights[light++] != LightStatus::Casts; });
  return {std::move(scene), std::move(plan)};
}

PlanOptions parse_plan_options(std::string_view text) {
  return {text == "everything" ? PlanKind::Everything : PlanKind::Needed, text.empty()};
}

}  // namespace farshade
