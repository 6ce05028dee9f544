/// GBufferTransfer copies base colours, shading normals and depth from the device's images to planes, and
/// planes to the images of another device. It keeps every word, so that both devices shade the same picture.
#pragma once

#include "stereo/frame/pixel_plane.h"
#include "stereo/raster/gbuffer.h"

namespace farshade {

class GBufferTransfer {
 public:
  /// Keeps the references. Allocates no memory before its first use.
  GBufferTransfer(gpu::FramesInFlight& frames, const GBufferPass& gbuffer, Extent size)
      : frames_(frames), device_(frames.device()), gbuffer_(gbuffer), size_(size) {}

  /// Copies what was drawn last, with its depth in `place`, to `planes`. Reuses their memory.
  void read(const DepthPlace& place, GBufferPlanes& planes);

  struct Pixel {
    std::uint32_t normal = 0;    ///< as packed by gbuffer.frag
    std::uint32_t instance = 0;  ///< 0 if the plan keeps no instances
    float depth = 0;
  };
  /// One pixel of what was drawn last. Waits for the copy.
  [[nodiscard]] Pixel read(const DepthPlace& place, Side side, glm::uvec2 pixel);

  /// Prepares `record` with planes of the pass's size. A pixel whose depth is NaN, below 0 or above 1 counts
  /// as not covered.
  void prepare(const GBufferPlanes& planes);

  /// Fills the images and `place` as if they had been drawn.
  void record(const vk::raii::CommandBuffer& commands, const DepthPlace& place);

 private:
  /// Offsets in a buffer with both eyes' layers of all images.
  struct Layout {
    std::size_t surface_words = 1;  ///< per pixel; the first is the normal
    std::size_t normals = 0, depths = 0, bytes = 0;
  };
  [[nodiscard]] Layout layout() const;

  gpu::FramesInFlight& frames_;
  const gpu::Device& device_;
  const GBufferPass& gbuffer_;
  Extent size_;
  gpu::ReadbackBuffer readback_, pixel_;  ///< allocated at first use
  gpu::HostMemory planes_;                ///< that were prepared and not recorded yet
};

}  // namespace farshade
