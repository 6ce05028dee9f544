/// ShadowMaps: the shadow maps of all lights on the device, for a client without a server. With
/// Redraw::WhenMoved they are redrawn only after a light or an instance has moved.
#pragma once

#include "stereo/draw/scene_pass.h"
#include "stereo/draw/shadow_map_views.h"

namespace farshade {

class ShadowMaps {
 public:
  /// Keeps the references. `frame` holds a FrameData. shadow_map_bytes must succeed for `scene` and
  /// `settings`. Throws when the device runs out of memory.
  ShadowMaps(const gpu::Device& device, const Scene& scene, const DrawPlan& plan, const SceneBuffers& buffers,
             const gpu::Buffer& frame, const ShadowMapSettings& settings);

  /// Prepares a frame with the shown views and the scene's state. Call before `record`.
  void prepare(const StereoView& shown, const SceneState& state);

  /// Draws the maps if `due`. Afterwards shaders can read them.
  void record(const vk::raii::CommandBuffer& commands);

  [[nodiscard]] const ShadowMapSettings& settings() const { return settings_; }
  /// Set 1 of shade.comp with SHADOW_MAPS: the maps, and a ShadowMapData for each light.
  [[nodiscard]] const gpu::Bindings& bindings() const { return bindings_; }
  [[nodiscard]] const ScenePass& scene_pass() const { return pass_; }
  /// Whether the maps must be redrawn for the last `prepare`.
  [[nodiscard]] bool due() const { return due_; }

 private:
  /// What the maps depend on.
  struct Content {
    std::vector<glm::dmat4> layer_clip;
    std::vector<Affine<Stage, Object>> stage_from_object;
    friend bool operator==(const Content&, const Content&) = default;
  };
  [[nodiscard]] std::vector<Point<Stage>> corners(const SceneState& state) const;

  const Scene& scene_;
  const SceneBuffers& buffers_;
  ShadowMapSettings settings_;
  gpu::Image maps_;
  std::vector<vk::raii::ImageView> pairs_;  ///< two layers each
  gpu::Buffer map_data_;                    ///< a ShadowMapData for each light
  vk::raii::Sampler nearest_{nullptr};
  gpu::Bindings bindings_;
  ScenePass pass_;
  Content drawn_;
  bool due_ = false;
};

}  // namespace farshade
