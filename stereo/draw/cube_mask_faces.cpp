#include "stereo/draw/cube_mask_faces.h"

namespace farshade {

CubeMaskFaces::CubeMaskFaces(gpu::FramesInFlight& frames, const Scene& scene, const DrawPlan& plan,
                             const SceneBuffers& buffers, const gpu::UploadBuffer& frame, Extent size,
                             std::shared_ptr<ScenePipelines> pipelines)
    : frames_(frames),
      scene_(scene),
      plan_(plan),
      buffers_(buffers),
      frame_buffer_(frame),
      pipelines_(std::move(pipelines)),
      ring_(frames.device(), face_size(size), kCubeMaskSlots, DepthImages::Shared) {
  if (!plan.builds_late) need_passes();
}

void CubeMaskFaces::need_passes() {
  if (!passes_.empty()) return;
  passes_.reserve(kCubeMaskPairs);
  for (std::size_t pair = 0; pair < kCubeMaskPairs; ++pair)
    passes_.emplace_back(frames_, scene_, plan_, buffers_, frame_buffer_, pipelines_);
}

void CubeMaskFaces::prepare(const ShownFrame& frame) {
  places_.clear();
  for (const FaceRequest& pair : frame.faces) {
    const std::optional<DepthPlace> place = ring_.claim(pair.request.frame, pair.slot);
    if (!place || places_.size() == kCubeMaskPairs) continue;
    need_passes();
    passes_[places_.size()].prepare(
        pair.request.views, plan_.anything_moves() ? state_at(scene_, pair.request.scene_time) : frame.state,
        frame.detail);
    places_.push_back(*place);
  }
}

void CubeMaskFaces::record(const vk::raii::CommandBuffer& commands) const {
  for (std::size_t pair = 0; pair < places_.size(); ++pair) passes_[pair].record(commands, places_[pair]);
}

std::uint64_t CubeMaskFaces::triangles() const {
  std::uint64_t triangles = 0;
  for (std::size_t pair = 0; pair < places_.size(); ++pair)
    triangles += passes_[pair].scene_pass().triangles();
  return triangles;
}

}  // namespace farshade
