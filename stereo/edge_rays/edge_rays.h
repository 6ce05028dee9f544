/// EdgeRays: what the device needs to trace the client's own shadow rays (shaders/edge_rays.comp): the
/// triangles that cast and never move, the alpha of those with holes, and a LightBuffer for each light that
/// rests.
#pragma once

#include "stereo/edge_rays/light_buffer.h"
#include "stereo/gpu/pass.h"
#include "stereo/gpu/upload_buffer.h"
#include "stereo/plan/scene_plan.h"

namespace farshade {

/// Light buffers, triangles and alpha take at most this, and no more texels than a buffer of the device can
/// have. If alpha does not fit, holes are unknown (caster_texels.h). From the first light on whose buffer
/// would take more, lights have none.
inline constexpr std::size_t kMostEdgeRayBytes = 64 << 20;

class EdgeRays {
 public:
  /// Makes the light buffers with all cores, and waits for the device. Keeps the reference to `frames`.
  /// Throws when the device runs out of memory.
  EdgeRays(gpu::FramesInFlight& frames, const Scene& scene, const DrawPlan& plan);

  /// Places the lights relative to the shown eyes. Returns those that rays can be traced to: they have a
  /// light buffer, and are where it was made for. `lights` are those of the scene.
  [[nodiscard]] LightBits prepare(const StereoView& shown, const LightSet& lights);
  void record_uploads(const vk::raii::CommandBuffer& commands) const {
    gpu::record_uploads(commands, {&places_});
  }

  /// Set 1 of edge_rays.comp.
  [[nodiscard]] const gpu::Bindings& bindings() const { return bindings_; }
  /// Of device memory.
  [[nodiscard]] std::size_t bytes() const { return words_.bytes + triangles_.bytes + alphas_.bytes; }

 private:
  /// A light, and where its buffer begins.
  struct Buffered {
    Light light;
    LightShadowMaps projection;
  };
  [[nodiscard]] std::vector<std::uint32_t> make_buffers(const Scene& scene, const CasterTriangles& casters,
                                                        std::size_t most_words);
  Point<Stage> origin_;  ///< of the triangles
  std::vector<Buffered> lights_;
  gpu::UploadBuffer places_;  ///< a ShadowMapData for each light, and one for the triangles' origin
  gpu::Buffer words_, triangles_, alphas_;
  vk::raii::BufferView places_view_{nullptr}, words_view_{nullptr}, triangles_view_{nullptr},
      alphas_view_{nullptr};
  gpu::Bindings bindings_;
};

}  // namespace farshade
