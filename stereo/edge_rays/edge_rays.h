/// EdgeRays: EdgeRayData on the device, for shaders/edge_rays.comp.
#pragma once

#include "stereo/edge_rays/edge_ray_data.h"
#include "stereo/gpu/pass.h"
#include "stereo/gpu/upload_buffer.h"

namespace farshade {

class EdgeRays {
 public:
  struct Texels {
    gpu::Buffer buffer;
    vk::raii::BufferView view{nullptr};
  };

  /// Keeps the reference to `frames`. `data` is for the scene, which has so many lights.
  EdgeRays(gpu::FramesInFlight& frames, std::size_t lights, FutureEdgeRayData data);

  /// Takes the data to the device if they have come; then it waits for the device. They are given up if the
  /// device has no memory for them. Places the lights relative to the shown eyes. Returns the lights that
  /// rays can be traced to: they have a light buffer, and are where it was made for. `lights` are those of
  /// the scene.
  [[nodiscard]] LightBits prepare(const StereoView& shown, const LightSet& lights);
  void record_uploads(const vk::raii::CommandBuffer& commands) const {
    gpu::record_uploads(commands, {&places_});
  }

  /// Set 1 of edge_rays.comp. `prepare` changes it only before it has returned a light.
  [[nodiscard]] const gpu::Bindings& bindings() const { return bindings_; }

 private:
  void load(const EdgeRayData& data);
  void take_if_ready();

  const gpu::Device& device_;
  FutureEdgeRayData data_;
  bool is_loaded_ = false;
  gpu::UploadBuffer places_;  ///< a ShadowMapData for each light, and one for the triangles' origin
  vk::raii::BufferView places_view_;
  Texels words_, triangles_, alphas_;
  gpu::Bindings bindings_;
};

}  // namespace farshade
