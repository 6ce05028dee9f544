/// Compose pass: the pictures of a composition, drawn into their panels (compose.frag).
#pragma once

#include "stereo/gpu/pass.h"
#include "stereo/image/image.h"
#include "vr_client/preview/composition.h"

namespace farshade {

class ComposePass {
 public:
  /// `eyes`: two layers, rgba8 UNORM, usable as storage image, in layout General whenever this pass is used,
  /// and kept. The pass draws within render passes that are compatible with `render_pass`.
  ComposePass(const gpu::Device& device, const gpu::Image& eyes, const vk::raii::RenderPass& render_pass);

  /// Takes a picture of the eyes' size in place of an eye; waits until the device has it.
  void upload(Side side, const Image<Rgb8>& picture);

  /// Before the render pass: what was drawn and uploaded becomes visible to it.
  void record_barrier(const vk::raii::CommandBuffer& commands) const;
  /// Within it, on `window` pixels that were cleared.
  void record(const vk::raii::CommandBuffer& commands, const Composition& composition, Extent window) const;

 private:
  enum class Filter : std::uint32_t { Nearest, Linear };
  enum class Blend : std::uint32_t { One, Anaglyph };
  [[nodiscard]] vk::raii::Pipeline make_pipeline(Filter filter, Blend blend,
                                                 const vk::raii::RenderPass& render_pass) const;
  void make_uploads();

  const gpu::Device& device_;
  Extent size_;
  gpu::Bindings bindings_;
  vk::raii::PipelineLayout layout_{nullptr};
  vk::raii::ShaderModule vertex_{nullptr}, fragment_{nullptr};
  std::vector<vk::raii::Pipeline> pipelines_;  ///< Blend after blend, of each nearest, then linear
  gpu::Image uploads_;                         ///< made when something is uploaded
  gpu::Buffer staging_;
};

}  // namespace farshade
