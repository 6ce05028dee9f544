/// GBufferPass draws base colours, normals and instances of the shown views, both eyes, and their depth into
/// a place of the depth ring. DepthPass draws the depth of requested views that are not shown.
#pragma once

#include "stereo/draw/depth_ring.h"
#include "stereo/draw/scene_pass.h"

namespace farshade {

class GBufferPass {
 public:
  /// The scene has at most kMaxInstances instances. `size` is in pixels per eye. Keeps the references.
  GBufferPass(const gpu::Device& device, const Scene& scene, const DrawPlan& plan,
              const SceneBuffers& buffers, const gpu::Buffer& frame, Extent size);

  void prepare(const StereoView& views, const SceneState& state, Detail detail) {
    pass_.prepare(views, state, detail);
  }

  /// Draws, with depth into `place` of `ring`. Afterwards shaders can read both images and the place.
  void record(const vk::raii::CommandBuffer& commands, const DepthRing& ring,
              const DepthRing::Place& place) const;

  void prepare_warm_up() { pass_.prepare_warm_up(); }

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

  void prepare_warm_up();

  /// Both views have one size, which is at most the ring's.
  void prepare(const StereoView& views, const SceneState& state, Detail detail);

  /// Draws into `place` of `ring`. Afterwards shaders can read it.
  void record(const vk::raii::CommandBuffer& commands, const DepthRing& ring,
              const DepthRing::Place& place) const;

  [[nodiscard]] const ScenePass& scene_pass() const { return pass_; }

 private:
  Extent size_;
  ScenePass pass_;
};

}  // namespace farshade
