#include "stereo/draw/shading_motion.h"

#include <algorithm>

namespace farshade {
namespace {

bool has_moved(const Motion& motion, std::size_t slot) {
  return slot < motion.then_from_now.size() && motion.then_from_now[slot].has_value();
}

/// Writes the stale lights and moved spheres of one group of masks: the newest (0) or all older ones (1).
bool write_group(const StereoView& views, MaskMotions since, std::size_t group, gpu::FrameData& frame) {
  std::bitset<kMaxLights> stale, changed;
  std::vector<Sphere> moved;
  for (const Motion* motion : since) {
    stale |= motion->stale_lights;
    changed |= motion->changed_lights;
    for (const Sphere& sphere : motion->moved) add_sphere(sphere, moved);
  }
  for (std::size_t i = 0; i < stale.size(); ++i) {
    const auto word = static_cast<int>(i / 32 % 4);
    if (stale[i]) frame.stale_lights[group * 2 + i / 128][word] |= 1u << i % 32;
    if (changed[i]) frame.changed_lights[i / 128][word] |= 1u << i % 32;
  }
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for (std::size_t i = 0; i < kMostSpheres; ++i) {
      glm::vec4& sphere = frame.moved[(group * kEyes + eye) * kMostSpheres + i];
      sphere = {0, 0, 0, -1};
      if (i < moved.size())
        sphere = glm::vec4(moved[i].centre.v - views[eye].stage_from_eye.translation,
                           moved[i].radius * moved[i].radius);
    }
  return stale.any() || !moved.empty();
}

}  // namespace

void write_motions(const StereoView& views, MaskMotions since, std::size_t slot,
                   std::span<glm::mat4> matrices) {
  for (std::size_t mask = 0; mask < since.size(); ++mask) {
    const MaskMotions group = mask == 0 ? since.first(1) : since.subspan(1);
    const bool flag =
        std::ranges::any_of(group, [&](const Motion* motion) { return has_moved(*motion, slot); });
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      const Rigid<Stage, Eye>& stage_from_eye = views[eye].stage_from_eye;
      glm::mat4& then_from_now = matrices[motion_index(slot, mask, eye)];
      then_from_now = glm::mat4(1.0f);
      if (has_moved(*since[mask], slot))
        then_from_now = glm::mat4(matrix(inverse(stage_from_eye)) * *since[mask]->then_from_now[slot] *
                                  matrix(stage_from_eye));
      then_from_now[0][3] = flag ? 1.0f : 0.0f;
    }
  }
}

bool write_stale(const StereoView& views, MaskMotions since, gpu::FrameData& frame) {
  const std::size_t newest = std::min<std::size_t>(since.size(), 1);
  const bool since_newest = write_group(views, since.first(newest), 0, frame);
  const bool since_older = write_group(views, since.subspan(newest), 1, frame);
  return since_newest || since_older;
}

}  // namespace farshade
