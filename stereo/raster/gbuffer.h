/// GBufferPass draws base colours, normals and instances of the shown views, both eyes, and their depth into
/// an image that is given. DepthPass draws the depth of requested views that are not shown.
#pragma once

#include "stereo/raster/depth_ring.h"
#include "stereo/raster/scene_pass.h"

namespace farshade {

class GBufferPass {
 public:
  /// The scene has at most kMaxInstances instances. `size` is in pixels per eye. Keeps the references.
  GBufferPass(gpu::FramesInFlight& frames, const Scene& scene, const DrawPlan& plan,
              const SceneBuffers& buffers, const gpu::UploadBuffer& frame, Extent size);

  /// `hidden`: what the lenses hide of the views; null: nothing.
  void prepare(const StereoView& views, const SceneState& state, Detail detail,
               const PerEye<HiddenArea>* hidden = nullptr) {
    pass_.prepare(views, state, detail);
    hidden_.prepare(hidden, views);
  }

  /// Draws, with depth into `place`. Afterwards shaders can read both images and the place.
  void record(const vk::raii::CommandBuffer& commands, const DepthPlace& place) const;

  void prepare_warm_up() {
    pass_.prepare_warm_up();
    hidden_.prepare(nullptr, {});
  }

  [[nodiscard]] const gpu::Image& base_colors() const { return base_colors_; }
  [[nodiscard]] const gpu::Image& surfaces() const { return surfaces_; }
  [[nodiscard]] const ScenePass& scene_pass() const { return pass_; }
  [[nodiscard]] const HiddenPass& hidden_pass() const { return hidden_; }

 private:
  Extent size_;
  ScenePass pass_;
  HiddenPass hidden_;
  gpu::Image base_colors_, surfaces_;
};

class DepthPass {
 public:
  /// Keeps the references. All depth passes of a renderer share `pipelines`.
  DepthPass(gpu::FramesInFlight& frames, const Scene& scene, const DrawPlan& plan,
            const SceneBuffers& buffers, const gpu::UploadBuffer& frame,
            std::shared_ptr<ScenePipelines> pipelines)
      : pass_(frames, scene, plan, buffers, frame, Outputs::Depth, 1, std::move(pipelines)),
        hidden_(frames, plan, Outputs::Depth) {}

  void prepare_warm_up();

  /// Both views have one size, which is at most that of the place. `hidden` as in GBufferPass.
  void prepare(const StereoView& views, const SceneState& state, Detail detail,
               const PerEye<HiddenArea>* hidden = nullptr);

  /// Draws into `place`. Afterwards shaders can read it.
  void record(const vk::raii::CommandBuffer& commands, const DepthPlace& place) const;

  [[nodiscard]] const ScenePass& scene_pass() const { return pass_; }
  [[nodiscard]] const HiddenPass& hidden_pass() const { return hidden_; }

 private:
  Extent size_;
  ScenePass pass_;
  HiddenPass hidden_;
};

}  // namespace farshade
