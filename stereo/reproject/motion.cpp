#include "stereo/reproject/motion.h"

#include <algorithm>

#include "stereo/base/check.h"

namespace farshade {
namespace {

bool changes_bits(const Light& then, const Light& now) {
  return then.kind != now.kind || then.position != now.position || then.direction != now.direction ||
         then.range_m != now.range_m || then.outer_cone_rad != now.outer_cone_rad;
}

Sphere sphere_about(const Affine<Stage, Object>& stage_from_object, const Bounds& box) {
  Sphere sphere{stage_from_object(Point<Object>{(box.low + box.high) * 0.5}), 0};
  for (int corner = 0; corner < 8; ++corner)
    sphere.radius =
        std::max(sphere.radius, length(stage_from_object(Point<Object>{box.corner(corner)}) - sphere.centre));
  return sphere;
}

}  // namespace

Sphere merged(const Sphere& a, const Sphere& b) {
  const Vector<Stage> offset = b.centre - a.centre;
  const double apart = length(offset);
  if (apart + b.radius <= a.radius) return a;
  if (apart + a.radius <= b.radius) return b;
  const double radius = (apart + a.radius + b.radius) / 2;
  return {a.centre + offset * ((radius - a.radius) / apart), radius};
}

void add_sphere(const Sphere& sphere, std::vector<Sphere>& spheres) {
  if (spheres.size() < kMostSpheres) {
    spheres.push_back(sphere);
    return;
  }
  const auto growth = [&](const Sphere& s) { return merged(s, sphere).radius - s.radius; };
  Sphere& best = *std::min_element(spheres.begin(), spheres.end(),
                                   [&](const Sphere& a, const Sphere& b) { return growth(a) < growth(b); });
  best = merged(best, sphere);
}

MotionModel::MotionModel(const Scene& scene, const std::vector<bool>& moves)
    : slots_(scene.instances.size(), 0) {
  check_eq(moves.size(), scene.instances.size(), "the plan is the scene's");
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
    if (!moves[i]) continue;
    Moving mover{i, bounds_of(scene.meshes[scene.instances[i].mesh].positions), {}};
    if (scene.instances[i].rig) mover.part.emplace(scene, i);
    moving_.push_back(std::move(mover));
    slots_[i] = static_cast<std::uint32_t>(moving_.size());
  }
}

std::optional<glm::dmat4> MotionModel::then_from_now(const Moving& mover, const SceneState& then,
                                                     const SceneState& now) {
  const Affine<Stage, Object>&before = then.stage_from_object[mover.instance],
                      &after = now.stage_from_object[mover.instance];
  const bool was_there = !is_singular(glm::dmat3(before.matrix)),
             is_there = !is_singular(glm::dmat3(after.matrix));
  if (!was_there && !is_there) return {};
  // It appears or disappears: masks of then have not seen it where it is now.
  if (!was_there || !is_there) return glm::dmat4(1.0);
  if (mover.part) return mover.part->then_from_now(then, now);
  if (before == after) return {};
  return before.matrix * glm::inverse(after.matrix);
}

Motion MotionModel::between(const SceneState& then, const SceneState& now) const {
  Motion motion;
  motion.then_from_now.resize(moving_.size());
  for (const LightChange& change : since(now.light_changes, then.light_set.revision, kMaxLights).lights)
    if (change.light < now.light_set.lights.size()) motion.changed_lights.set(change.light);
  motion.stale_lights = motion.changed_lights;
  const bool moves = !same_instant(then.scene_time, now.scene_time);
  for (std::size_t i = 0; i < now.light_set.lights.size(); ++i) {
    const Light &before = then.light_set.lights[i], &after = now.light_set.lights[i];
    if (moves && changes_bits(before, after)) motion.stale_lights.set(i);
    if (!after.on) motion.stale_lights.reset(i);
  }
  if (!moves) return motion;
  for (std::size_t slot = 0; slot < moving_.size(); ++slot) {
    const Moving& mover = moving_[slot];
    motion.then_from_now[slot] = then_from_now(mover, then, now);
    if (!motion.then_from_now[slot]) continue;
    for (const SceneState* state : {&then, &now}) add_bounds(mover, *state, motion.moved);
  }
  return motion;
}

std::vector<Sphere> MotionModel::bounds(const SceneState& now) const {
  std::vector<Sphere> spheres;
  for (const Moving& mover : moving_) add_bounds(mover, now, spheres);
  return spheres;
}

void MotionModel::add_bounds(const Moving& mover, const SceneState& state, std::vector<Sphere>& spheres) {
  const Affine<Stage, Object>& place = state.stage_from_object[mover.instance];
  if (is_singular(glm::dmat3(place.matrix))) return;
  add_sphere(sphere_about(place, mover.part ? mover.part->bounds(state) : mover.box), spheres);
}

}  // namespace farshade
