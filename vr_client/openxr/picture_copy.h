/// Copies pictures and depths to images of the runtime.
#pragma once

#include <span>

#include "stereo/gpu/memory.h"

namespace farshade::openxr {

/// Layers of an image of ours, one for each eye, and the image of the runtime that they go to.
struct LayerCopy {
  const gpu::Image& from;
  std::uint32_t first_layer;    ///< of `from`
  vk::ImageLayout from_layout;  ///< which `from` keeps
  vk::Image to;                 ///< a format with as many bytes a pixel
  vk::ImageLayout to_layout;    ///< of `to` afterwards; its content and layout before do not matter
};

/// Copies the upper left part of `size` of each layer, without conversion.
void record_copies(const vk::raii::CommandBuffer& commands, std::span<const LayerCopy> copies, Extent size);

}  // namespace farshade::openxr
