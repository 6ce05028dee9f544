/// ComposePass: draws the pictures of a composition into their rectangles. It blits them, because on a CPU
/// device a blit is faster than a shader (1.8 against 2.5 ms for two eyes of 512 x 512). Only the anaglyph
/// uses a shader (anaglyph.frag).
#pragma once

#include "stereo/gpu/pass.h"
#include "stereo/image/image.h"
#include "vr_client/preview/composition.h"

namespace farshade {

/// The target image: 8-bit UNORM, usable as colour attachment and transfer destination.
struct ComposeTarget {
  vk::Image image;
  vk::ImageView view;
  Extent size;
};

class ComposePass {
 public:
  /// `eyes` has two layers of rgba8 UNORM, is usable as storage image and transfer source, and is in layout
  /// General between uses. The references are kept. Targets have `format`.
  ComposePass(const gpu::Device& device, const gpu::Image& eyes, vk::Format format);

  /// Uploads a picture of the eyes' size that replaces an eye. Waits for the upload.
  void upload(Side side, const Image<Rgb8>& picture);

  /// Overwrites all of `target`; pixels outside of the rectangles are black. Leaves it in layout
  /// TransferDstOptimal.
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
  vk::raii::Pipeline nearest_{nullptr}, linear_{nullptr};  ///< pipelines of the anaglyph
  gpu::Image uploads_;                                     ///< created by the first upload
  gpu::StagingBuffer staging_;
};

}  // namespace farshade
