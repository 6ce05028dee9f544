#include "stereo/reproject/shading_motion.h"

#include <algorithm>

#include "stereo/base/check.h"

namespace farshade {
namespace {

bool has_moved(const Motion& motion, std::size_t slot) {
  return slot < motion.then_from_now.size() && motion.then_from_now[slot].has_value();
}

using Motions = std::span<const Motion* const>;

/// The masks of a group.
Motions group_of(const MaskMotions& since, std::size_t group) {
  if (group == FARSHADE_SINCE_CUBE_MASK) return since.cube_mask;
  const std::size_t newest = std::min<std::size_t>(since.masks.size(), 1);
  return group == FARSHADE_SINCE_NEWEST ? since.masks.first(newest) : since.masks.subspan(newest);
}

/// Writes the stale lights and moved spheres of one group.
bool write_group(const StereoView& views, const MaskMotions& since, std::size_t group,
                 gpu::FrameData& frame) {
  std::bitset<kMaxLights> stale, changed;
  std::vector<Sphere> moved;
  for (const Motion* motion : group_of(since, group)) {
    stale |= motion->stale_lights;
    changed |= motion->changed_lights;
    for (const Sphere& sphere : motion->moved) add_sphere(sphere, moved);
  }
  for (std::size_t i = 0; i < stale.size(); ++i) {
    const auto word = static_cast<int>(i / 32 % 4);
    if (stale[i]) frame.stale_lights[group * 2 + i / 128][word] |= 1u << i % 32;
    if (changed[i]) frame.changed_lights[i / 128][word] |= 1u << i % 32;
  }
  write_spheres(views, moved,
                std::span(frame.moved).subspan(group * kEyes * kMostSpheres, kEyes * kMostSpheres));
  return stale.any() || !moved.empty();
}

}  // namespace

void write_spheres(const StereoView& views, std::span<const Sphere> spheres, std::span<gpu::vec4> into) {
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for (std::size_t i = 0; i < kMostSpheres; ++i) {
      glm::vec4& sphere = into[eye * kMostSpheres + i];
      sphere = {0, 0, 0, -1};
      if (i < spheres.size())
        sphere = glm::vec4(spheres[i].centre.v - views[eye].stage_from_eye.translation,
                           spheres[i].radius * spheres[i].radius);
    }
}

void write_motions(const StereoView& views, const MaskMotions& since, std::size_t slot,
                   WriteOnly<glm::mat4> matrices) {
  check(motion_index(slot + 1, 0, 0) <= matrices.size(), "the buffer has the matrices of every slot");
  for (std::size_t group = 0; group < FARSHADE_SINCE_GROUPS; ++group) {
    const Motions motions = group_of(since, group);
    const bool flag =
        std::ranges::any_of(motions, [&](const Motion* motion) { return has_moved(*motion, slot); });
    const std::size_t first = group == FARSHADE_SINCE_CUBE_MASK ? FARSHADE_MAX_MASKS : group;
    for (std::size_t i = 0; i < motions.size(); ++i)
      for (std::size_t eye = 0; eye < kEyes; ++eye) {
        const Rigid<Stage, Eye>& stage_from_eye = views[eye].stage_from_eye;
        glm::mat4 then_from_now(1.0f);
        if (has_moved(*motions[i], slot))
          then_from_now = glm::mat4(matrix(inverse(stage_from_eye)) * *motions[i]->then_from_now[slot] *
                                    matrix(stage_from_eye));
        then_from_now[0][3] = flag ? 1.0f : 0.0f;
        matrices.write(motion_index(slot, first + i, eye), then_from_now);
      }
  }
}

bool write_stale(const StereoView& views, const MaskMotions& since, gpu::FrameData& frame) {
  bool any = false;
  for (std::size_t group = 0; group < FARSHADE_SINCE_GROUPS; ++group)
    any |= write_group(views, since, group, frame);
  return any;
}

}  // namespace farshade
