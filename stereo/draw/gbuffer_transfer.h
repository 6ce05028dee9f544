/// G-buffer transfer: base colours, shading normals and depth out of the device's images, and back into those
/// of another device, word by word, so that both shade to the same picture.
#pragma once

#include "stereo/draw/gbuffer.h"
#include "stereo/frame/pixel_plane.h"

namespace farshade {

class GBufferTransfer {
 public:
  /// References are kept. Takes no memory before it is used.
  GBufferTransfer(const gpu::Device& device, const GBufferPass& gbuffer, const DepthRing& ring, Extent size)
      : device_(device), gbuffer_(gbuffer), ring_(ring), size_(size) {}

  /// What was drawn last, its depth in `place`, into `planes`, whose memory is reused.
  void read(const DepthRing::Place& place, GBufferPlanes& planes);

  /// Puts planes of the pass's size ready for `record`. Depths that are no near / distance - NaN, below 0,
  /// above 1 - are taken as not covered.
  void prepare(const GBufferPlanes& planes);

  /// Fills the images and `place`, as if they had been drawn.
  void record(const vk::raii::CommandBuffer& commands, const DepthRing::Place& place) const;

 private:
  /// Of a buffer that holds both eyes' layers of all images.
  struct Layout {
    std::size_t surface_words = 1;  ///< a pixel; the normal is the first
    std::size_t normals = 0, depths = 0, bytes = 0;
  };
  [[nodiscard]] Layout layout() const;

  const gpu::Device& device_;
  const GBufferPass& gbuffer_;
  const DepthRing& ring_;
  Extent size_;
  gpu::Buffer readback_, upload_;  ///< once needed
};

}  // namespace farshade
