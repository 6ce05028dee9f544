/// ShadowMaps: the shadow maps of all lights on the device, for a client without a server. With
/// Redraw::WhenMoved a frame draws only what ShadowMapUpdates finds; the maps are the same as with
/// Redraw::Always.
#pragma once

#include "stereo/raster/scene_pass.h"
#include "stereo/shadow_maps/shadow_map_updates.h"
#include "stereo/shadow_maps/shadow_map_views.h"

namespace farshade {

/// Layers of shadow maps that a frame draws. The others stay as they are.
struct MapLayerCounts {
  std::uint64_t drawn = 0;     ///< with the instances that cannot move
  std::uint64_t restored = 0;  ///< from kept depth; only moving instances are drawn
};

class ShadowMaps {
 public:
  /// Keeps the references. `frame` holds a FrameData. shadow_map_bytes must succeed for `scene` and
  /// `settings`. Throws when the device runs out of memory.
  ShadowMaps(gpu::FramesInFlight& frames, const Scene& scene, const DrawPlan& plan,
             const SceneBuffers& buffers, const gpu::UploadBuffer& frame, const ShadowMapSettings& settings);

  /// Prepares a frame with the shown views and the scene's state. `record` must follow.
  void prepare(const StereoView& shown, const SceneState& state);

  /// Draws what the last `prepare` found. Afterwards shaders can read the maps.
  void record(const vk::raii::CommandBuffer& commands) const;

  [[nodiscard]] const ShadowMapSettings& settings() const { return settings_; }
  /// Set 1 of shade.comp with SHADOW_MAPS: the maps, and a ShadowMapData for each light.
  [[nodiscard]] const gpu::Bindings& bindings() const { return bindings_; }
  [[nodiscard]] const ScenePass& scene_pass() const { return pass_; }
  /// Whether `record` draws anything.
  [[nodiscard]] bool due() const { return !passes_.empty(); }
  [[nodiscard]] MapLayerCounts layers_drawn() const { return drawn_; }

 private:
  /// An image of depth and its pairs of layers.
  struct DepthLayers {
    gpu::Image image;
    std::vector<vk::raii::ImageView> pairs;
  };
  [[nodiscard]] static DepthLayers make_layers(const gpu::Device& device, std::uint32_t count,
                                               std::uint32_t side_px, vk::ImageUsageFlags usage,
                                               const std::string& name);
  void find_corners(const SceneState& state);
  [[nodiscard]] std::vector<CasterPlace> places(const SceneState& state) const;
  void add_passes(const std::vector<LayerUpdate>& updates, std::span<const glm::dmat4> layer_clip);
  void add_copy(std::uint32_t layer, const TexelRect& lost);
  void record_kept(const vk::raii::CommandBuffer& commands) const;
  void record_pass(const vk::raii::CommandBuffer& commands, std::size_t pass, vk::ImageView pair) const;

  const Scene& scene_;
  const SceneBuffers& buffers_;
  ShadowMapSettings settings_;
  MapLayers layers_;
  DepthLayers maps_;
  std::optional<DepthLayers> kept_;  ///< depth of the instances that cannot move
  gpu::UploadBuffer map_data_;       ///< a ShadowMapData for each light
  vk::raii::Sampler nearest_{nullptr};
  gpu::Bindings bindings_;
  ScenePass pass_;
  ShadowMapUpdates updates_;
  std::vector<Point<Stage>> corners_;  ///< of all instances: first of those that cannot move
  std::size_t fixed_corners_ = 0;      ///< their number once they are known
  // What the prepared frame draws.
  std::vector<CasterDraws> passes_;  ///< first those into kept depth
  std::size_t kept_passes_ = 0;
  std::vector<vk::ImageCopy> copies_;  ///< from kept depth to the maps
  MapLayerCounts drawn_;
};

}  // namespace farshade
