/// G-buffer pass: both eyes of the shown views - base colour, normals, instance - with their depth in a place
/// of the ring. Requested views other than the shown ones need their depth alone.
#pragma once

#include "stereo/draw/depth_ring.h"
#include "stereo/draw/scene_pass.h"

namespace farshade {

/// The G-buffer has 16 bits for an instance.
inline constexpr std::size_t kMaxInstances = 1 << 16;

class GBufferPass {
 public:
  /// At most kMaxInstances instances. `size` pixels an eye. References are kept.
  GBufferPass(const gpu::Device& device, const Scene& scene, const DrawPlan& plan,
              const SceneBuffers& buffers, const gpu::Buffer& frame, Extent size);

  void prepare(const StereoView& views, const SceneState& state) { pass_.prepare(views, state); }

  /// Draws, depth into `place` of `ring`. Afterwards both images and the place are readable by shaders.
  void record(const vk::raii::CommandBuffer& commands, const DepthRing& ring,
              const DepthRing::Place& place) const;

  [[nodiscard]] const gpu::Image& base_colors() const { return base_colors_; }
  [[nodiscard]] const gpu::Image& surfaces() const { return surfaces_; }
  [[nodiscard]] const ScenePass& scene_pass() const { return pass_; }

 private:
  Extent size_;
  ScenePass pass_;
  gpu::Image base_colors_, surfaces_;
};

class DepthPass {
 public:
  DepthPass(const gpu::Device& device, const Scene& scene, const DrawPlan& plan, const SceneBuffers& buffers,
            const gpu::Buffer& frame)
      : pass_(device, scene, plan, buffers, frame, Outputs::Depth) {}

  /// Both views have one size, at most the ring's.
  void prepare(const StereoView& views, const SceneState& state);

  /// Draws into `place` of `ring`, which is readable by shaders afterwards.
  void record(const vk::raii::CommandBuffer& commands, const DepthRing& ring,
              const DepthRing::Place& place) const;

  [[nodiscard]] const ScenePass& scene_pass() const { return pass_; }

 private:
  Extent size_;
  ScenePass pass_;
};

}  // namespace farshade
