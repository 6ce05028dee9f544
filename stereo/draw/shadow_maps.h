/// ShadowMaps: the depth maps of all lights on the device, for a client without a server. They are drawn
/// again only where a light or an instance stands elsewhere than when they were drawn last.
#pragma once

#include "stereo/draw/scene_pass.h"
#include "stereo/draw/shadow_map_views.h"

namespace farshade {

class ShadowMaps {
 public:
  /// References are kept. `frame` holds a FrameData; `wish` is one that shadow_map_bytes does not refuse for
  /// `scene`. Throws when the device runs out of memory.
  ShadowMaps(const gpu::Device& device, const Scene& scene, const DrawPlan& plan, const SceneBuffers& buffers,
             const gpu::Buffer& frame, const ShadowMapSettings& wish);

  /// For a frame that shows `shown` in `state`. Call before `record`.
  void prepare(const StereoView& shown, const SceneState& state);

  /// Draws the maps if they are not as the state wants them. Afterwards they are readable by shaders.
  void record(const vk::raii::CommandBuffer& commands);

  [[nodiscard]] const ShadowMapSettings& wish() const { return wish_; }
  /// Set 1 of shade.comp with SHADOW_MAPS: the maps, and a ShadowMapData of each light.
  [[nodiscard]] const gpu::Bindings& bindings() const { return bindings_; }
  [[nodiscard]] const ScenePass& scene_pass() const { return pass_; }
  /// Whether the last `prepare` wanted them drawn.
  [[nodiscard]] bool due() const { return due_; }

 private:
  /// What the maps show.
  struct Content {
    std::vector<glm::dmat4> layer_clip;
    std::vector<Affine<Stage, Object>> stage_from_object;
    friend bool operator==(const Content&, const Content&) = default;
  };
  [[nodiscard]] std::vector<Point<Stage>> corners(const SceneState& state) const;

  const Scene& scene_;
  const SceneBuffers& buffers_;
  ShadowMapSettings wish_;
  gpu::Image maps_;
  std::vector<vk::raii::ImageView> pairs_;  ///< of two layers each
  gpu::Buffer places_;
  vk::raii::Sampler nearest_{nullptr};
  gpu::Bindings bindings_;
  ScenePass pass_;
  Content drawn_;
  bool due_ = false;
};

}  // namespace farshade
