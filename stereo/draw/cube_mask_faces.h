/// CubeMaskFaces: the depth of the faces of the cube mask that were requested (docs/cube-mask.md), in a ring
/// of its own, and the passes that draw it: one for each pair that a frame may request.
#pragma once

#include <span>
#include <vector>

#include "stereo/draw/renderer.h"
#include "stereo/raster/gbuffer.h"

namespace farshade {

class CubeMaskFaces {
 public:
  /// For shown views of `size`. Keeps the references. If the plan does not build late, the passes exist at
  /// once. They share `pipelines` with the other depth passes.
  CubeMaskFaces(gpu::FramesInFlight& frames, const Scene& scene, const DrawPlan& plan,
                const SceneBuffers& buffers, const gpu::UploadBuffer& frame, Extent size,
                std::shared_ptr<ScenePipelines> pipelines);

  /// Chooses where the depth of the requested pairs of a frame goes, and prepares `record`.
  void prepare(const ShownFrame& frame);
  /// Draws the depth of the prepared pairs.
  void record(const vk::raii::CommandBuffer& commands) const;

  [[nodiscard]] const DepthRing& ring() const { return ring_; }
  void forget() { ring_.forget(); }
  /// The passes that exist. The first of them draw the prepared pairs.
  [[nodiscard]] std::span<const DepthPass> passes() const { return passes_; }
  [[nodiscard]] std::size_t pairs() const { return places_.size(); }
  /// Of the prepared pairs.
  [[nodiscard]] std::uint64_t triangles() const;

 private:
  void need_passes();

  gpu::FramesInFlight& frames_;
  const Scene& scene_;
  const DrawPlan& plan_;
  const SceneBuffers& buffers_;
  const gpu::UploadBuffer& frame_buffer_;
  std::shared_ptr<ScenePipelines> pipelines_;
  DepthRing ring_;
  std::vector<DepthPass> passes_;   ///< created at first use
  std::vector<DepthPlace> places_;  ///< one for each prepared pair
};

}  // namespace farshade
