/// Compose pass: the pictures of a composition in their panels. They are copied, at one to one pixel by
/// pixel, which costs a CPU device less than a shader that reads them (1.8 against 2.5 ms for two eyes of 512
/// x 512); only an anaglyph is computed (anaglyph.frag).
#pragma once

#include "stereo/gpu/pass.h"
#include "stereo/image/image.h"
#include "vr_client/preview/composition.h"

namespace farshade {

/// A colour image to compose into, 8-bit UNORM, usable as colour attachment and as transfer destination.
struct ComposeTarget {
  vk::Image image;
  vk::ImageView view;
  Extent size;
};

class ComposePass {
 public:
  /// `eyes`: two layers, rgba8 UNORM, usable as storage image and transfer source, in layout General between
  /// uses, and kept. Targets have `format`.
  ComposePass(const gpu::Device& device, const gpu::Image& eyes, vk::Format format);

  /// Takes a picture of the eyes' size in place of an eye; waits until the device has it.
  void upload(Side side, const Image<Rgb8>& picture);

  /// All of `target`, whatever was in it; what is no panel is black. Leaves it in layout TransferDstOptimal.
  void record(const vk::raii::CommandBuffer& commands, const Composition& composition,
              const ComposeTarget& target) const;

 private:
  enum class Filter : std::uint32_t { Nearest, Linear };
  [[nodiscard]] vk::raii::Pipeline make_pipeline(Filter filter, vk::Format format) const;
  void make_uploads();
  void copy(const vk::raii::CommandBuffer& commands, Picture picture, const Panel& panel,
            vk::Image target) const;
  void draw_anaglyph(const vk::raii::CommandBuffer& commands, const Composition& composition,
                     const Panel& panel, Extent eye, const ComposeTarget& target) const;

  const gpu::Device& device_;
  const gpu::Image& eyes_;
  gpu::Bindings bindings_;
  vk::raii::PipelineLayout layout_{nullptr};
  vk::raii::ShaderModule vertex_{nullptr}, fragment_{nullptr};
  vk::raii::Pipeline nearest_{nullptr}, linear_{nullptr};  ///< of the anaglyph
  gpu::Image uploads_;                                     ///< made when something is uploaded
  gpu::Buffer staging_;
};

}  // namespace farshade
