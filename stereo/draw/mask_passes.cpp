#include "stereo/draw/mask_passes.h"

#include "stereo/plan/plan_masks.h"

namespace farshade {
namespace {

/// A mask of the views of a request of which nothing is known.
OwnedMask unknown_mask(const FrameMoment& request, MaskLayout layout) {
  OwnedMask mask{.frame = {request.frame, request.lights.revision, request.views, {}},
                 .display_time = request.display_time,
                 .scene_time = request.scene_time};
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const Extent size = request.views[eye].size;
    mask.frame.masks[eye] = EyeMask(size, layout);
    mask.received_tiles[eye].assign(TileGrid{size}.count(), 0);
  }
  return mask;
}

}  // namespace

MaskPasses::MaskPasses(gpu::FramesInFlight& frames, const Scene& scene, const DrawPlan& plan,
                       const SceneBuffers& buffers, const gpu::UploadBuffer& frame,
                       const RendererLimits& limits, const DepthPlace& any_depth)
    : frames_(frames),
      scene_(scene),
      plan_(plan),
      buffers_(buffers),
      frame_buffer_(frame),
      traced_size_(limits.traced_size),
      any_(any_depth),
      motion_(scene, plan.moves),
      ring_(frames.device(), limits.traced_size, limits.depth_frames, DepthImages::Single),
      masks_(frames, plan, shading_bytes(plan, limits.size, limits.traced_size)) {
  if (most_cube_mask_pairs(plan) > 0)
    faces_.emplace(frames, scene, plan, buffers, frame, limits.size, pipelines_);
  if (plan.depth_pass && !plan.builds_late) static_cast<void>(need_depth_pass());
}

DepthPass& MaskPasses::need_depth_pass() {
  if (!depth_pass_) depth_pass_.emplace(frames_, scene_, plan_, buffers_, frame_buffer_, pipelines_);
  return *depth_pass_;
}

RequestReprojectionPass& MaskPasses::need_reprojection() {
  if (!reprojection_) reprojection_.emplace(frames_, plan_, any_, traced_size_);
  return *reprojection_;
}

/// What has moved since a mask was traced.
Motion MaskPasses::motion_since(const TracedMask& mask, const SceneState& now) const {
  const bool moves = plan_.anything_moves() && !same_instant(mask.scene_time, now.scene_time);
  if (!moves && mask.light_set_revision == now.light_set.revision) return {};
  return motion_.between(state_at(scene_, mask.scene_time, up_to(now.light_changes, mask.light_set_revision)),
                         now);
}

bool MaskPasses::prepare(const FrameMoment& request, std::size_t slot, const TracedMask* base,
                         const PerEye<HiddenArea>* hidden) {
  if (!reprojects_masks(plan_) || (base != nullptr && !ring_.has(base->frame))) return false;
  const std::optional<DepthPlace> place = ring_.claim(request.frame, slot);
  if (!place) return false;
  try {
    return prepare_at(*place, request, base, hidden);
  } catch (...) {
    ring_.release(request.frame);
    throw;
  }
}

bool MaskPasses::prepare_at(const DepthPlace& place, const FrameMoment& request, const TracedMask* base,
                            const PerEye<HiddenArea>* hidden) {
  if (base != nullptr && !ring_.has(base->frame)) {  // its depth was in this slot
    ring_.release(request.frame);
    return false;
  }
  std::optional<OwnedMask> unknown;
  const TracedMask from =
      base != nullptr ? *base : unknown.emplace(unknown_mask(request, plan_.mask)).traced();
  const SceneState state = state_at(scene_, request.scene_time, request.lights);
  Motion since = motion_since(from, state);
  since.stale_lights |= since.changed_lights;  // those that are off now, too: their bits are 0
  requested_ = place;
  need_depth_pass().prepare(request.views, state, Detail::Levels, hidden);
  need_reprojection().prepare(request, {.requested = place, .base = ring_.place_of(from.frame)}, from,
                              state.light_set, since);
  return true;
}

void MaskPasses::record_depth(const vk::raii::CommandBuffer& commands) const {
  depth_pass_->record(commands, requested_);
}

MasksInUse MaskPasses::usable(std::span<const TracedMask> masks, std::span<const TracedMask> cube_mask,
                              const SceneState& now, Lookup lookup) {
  MasksInUse used;
  const bool is_direct = lookup == Lookup::Direct || !reprojects_masks(plan_);
  for (const TracedMask& mask : masks)
    if (used.views.size() < most_masks(plan_) && (is_direct || ring_.has(mask.frame)))
      used.views.push_back({mask, motion_since(mask, now)});
  if (reprojects_masks(plan_)) ring_.give_back_unused(masks, most_masks(plan_));
  for (const TracedMask& mask : cube_mask)
    if (used.cube_mask.size() < most_cube_mask_pairs(plan_) && !is_direct && faces_->ring().has(mask.frame))
      used.cube_mask.push_back({mask, motion_since(mask, now)});
  if (plan_.edge_rays) used.movable = motion_.bounds(now);
  return used;
}

void MaskPasses::forget() {
  ring_.forget();
  if (faces_) faces_->forget();
  masks_.forget();
}

}  // namespace farshade
