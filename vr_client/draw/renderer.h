/// Renderer: one shown frame, from views to pixels: G-buffer, then masks carried over and shaded.
/// One frame at a time; draw returns when the device has finished.
#pragma once

#include "stereo/image/image.h"
#include "vr_client/draw/shading.h"

namespace farshade {

struct DrawTimes {
  Duration gbuffer{}, shade{};  ///< on the device
  Duration total{};             ///< wall time of the call: recording, uploads, submission and wait as well
};

struct ShownFrame {
  FrameId frame;
  StereoView views;  ///< both eyes of the renderer's size
  const SceneState& state;
  std::span<const MaskInHand> masks;  ///< newest first; those whose depth has left the ring are passed over
  Lookup lookup = Lookup::Reproject;
  ShadingPass::Report report = ShadingPass::Report::Off;
};

class Renderer {
 public:
  /// `size` pixels an eye; masks up to `depth_frames` frames old can be used. References are kept.
  /// Throws when the device runs out of memory.
  Renderer(const gpu::Device& device, const Scene& scene, Extent size, std::uint32_t depth_frames);

  DrawTimes draw(const ShownFrame& frame);

  /// Shades the last frame drawn again, with `reference` traced for its very views.
  DrawTimes shade_again(const ShownFrame& frame, const MaskInHand& reference);

  /// The G-buffer pass alone: what a client without shadows would pay.
  DrawTimes draw_gbuffer(const ShownFrame& frame);

  [[nodiscard]] bool has_depth(FrameId frame) const { return gbuffer_.has_depth(frame); }

  // Of the last draw.
  [[nodiscard]] PerEye<Image<Rgb8>> read_shown() const;
  [[nodiscard]] ShownReport report(Side side) const { return shading_.report(side); }
  /// Metres along -z, 0 where nothing is covered.
  [[nodiscard]] PerEye<Image<float>> read_distance(FrameId frame) const;

 private:
  enum class Stage : std::uint8_t { GBuffer, Shade, Both };
  DrawTimes submit(const ShownFrame& frame, Stage stage, Lookup lookup);
  void read_back(const gpu::Image& image, vk::ImageLayout layout, gpu::LayerRange layers) const;

  const gpu::Device& device_;
  Extent size_;
  GBufferPass gbuffer_;
  ShadingPass shading_;
  vk::raii::CommandBuffer commands_{nullptr};
  vk::raii::Fence fence_{nullptr};
  gpu::Timestamps stamps_;
  gpu::Buffer readback_;
};

}  // namespace farshade
