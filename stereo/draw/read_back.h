/// ReadBack: copies the layers of both eyes of an image to the host.
#pragma once

#include <span>

#include "stereo/frame/view.h"
#include "stereo/gpu/memory.h"

namespace farshade {

class ReadBack {
 public:
  /// Keeps the reference.
  explicit ReadBack(const gpu::Device& device) : device_(device) {}

  /// The top left `size` pixels of two layers from `first_layer` on, of an image in `layout` with four bytes
  /// per pixel; the left eye's rows first. Valid until the next call. T is a type of four bytes.
  template <class T>
  std::span<const T> read(const gpu::Image& image, vk::ImageLayout layout, std::uint32_t first_layer,
                          Extent size) {
    static_assert(sizeof(T) == 4);
    copy(image, layout, first_layer, size);
    return buffer_.as<T>();
  }

 private:
  void copy(const gpu::Image& image, vk::ImageLayout layout, std::uint32_t first_layer, Extent size);

  const gpu::Device& device_;
  gpu::ReadbackBuffer buffer_;  ///< grows as needed
};

}  // namespace farshade
