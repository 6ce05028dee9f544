/// MaskPasses: what a renderer does for masks besides shading with them. It keeps the depth of the views that
/// masks were requested for, reprojects a mask to the views of the next request, and selects the masks that a
/// frame can use.
#pragma once

#include <optional>

#include "stereo/draw/cube_mask_faces.h"
#include "stereo/reproject/request_reprojection_pass.h"
#include "stereo/reproject/shading.h"

namespace farshade {

class MaskPasses {
 public:
  /// `frame` holds a FrameData. `any_depth` is bound where there is no depth. Keeps the references.
  MaskPasses(gpu::FramesInFlight& frames, const Scene& scene, const DrawPlan& plan,
             const SceneBuffers& buffers, const gpu::UploadBuffer& frame, const RendererLimits& limits,
             const DepthPlace& any_depth);

  /// Prepares the depth of the views of `request` and, from `base`, what is known there; arguments and result
  /// are those of Renderer::reproject_to_request.
  [[nodiscard]] bool prepare(const FrameMoment& request, std::size_t slot, const TracedMask* base,
                             const PerEye<HiddenArea>* hidden);
  void record_depth(const vk::raii::CommandBuffer& commands) const;
  /// After record_depth.
  void record_reprojection(const vk::raii::CommandBuffer& commands) { reprojection_->record(commands); }
  /// What record_reprojection has found. Call after the device has finished. Reuses the memory of `into`.
  void read(RequestReprojection& into) const { reprojection_->read(into); }

  /// Those of `masks` and `cube_mask` whose depth is kept, with what has moved since. Requests that are older
  /// than all of these give their depth back.
  [[nodiscard]] MasksInUse usable(std::span<const TracedMask> masks, std::span<const TracedMask> cube_mask,
                                  const SceneState& now, Lookup lookup);

  /// Forgets the depth of all requests and all masks.
  void forget();

  [[nodiscard]] MaskDepths depths() const { return {ring_, faces_ ? &faces_->ring() : nullptr, any_}; }
  [[nodiscard]] bool has_depth(FrameId frame) const {
    return ring_.has(frame) || (faces_ && faces_->ring().has(frame));
  }
  [[nodiscard]] DepthRing& ring() { return ring_; }
  [[nodiscard]] DeviceMasks& masks() { return masks_; }
  [[nodiscard]] const DeviceMasks& masks() const { return masks_; }
  [[nodiscard]] const MotionModel& motion() const { return motion_; }
  [[nodiscard]] std::optional<CubeMaskFaces>& faces() { return faces_; }
  [[nodiscard]] const std::optional<CubeMaskFaces>& faces() const { return faces_; }

  // Created at first use.
  [[nodiscard]] DepthPass& need_depth_pass();
  [[nodiscard]] RequestReprojectionPass& need_reprojection();
  [[nodiscard]] const std::optional<DepthPass>& depth_pass() const { return depth_pass_; }
  [[nodiscard]] const std::optional<RequestReprojectionPass>& reprojection() const { return reprojection_; }
  /// Of all depth passes.
  [[nodiscard]] std::size_t depth_pipelines() const { return pipelines_->size(); }

 private:
  [[nodiscard]] bool prepare_at(const DepthPlace& place, const FrameMoment& request, const TracedMask* base,
                                const PerEye<HiddenArea>* hidden);
  [[nodiscard]] Motion motion_since(const TracedMask& mask, const SceneState& now) const;

  gpu::FramesInFlight& frames_;
  const Scene& scene_;
  const DrawPlan& plan_;
  const SceneBuffers& buffers_;
  const gpu::UploadBuffer& frame_buffer_;
  Extent traced_size_;
  DepthPlace any_;
  MotionModel motion_;
  DepthRing ring_;
  std::shared_ptr<ScenePipelines> pipelines_ = std::make_shared<ScenePipelines>();
  std::optional<CubeMaskFaces> faces_;  ///< set if the plan has a cube mask
  std::optional<DepthPass> depth_pass_;
  DeviceMasks masks_;
  std::optional<RequestReprojectionPass> reprojection_;
  DepthPlace requested_;  ///< of the prepared request
};

}  // namespace farshade
