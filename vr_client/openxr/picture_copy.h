/// PictureCopy: copies the shown picture to an image of the runtime.
#pragma once

#include "stereo/gpu/memory.h"

namespace farshade::openxr {

class PictureCopy {
 public:
  /// Keeps both references. `shown`: layout General, one layer an eye.
  PictureCopy(const gpu::Device& device, const gpu::Image& shown);

  /// Copies the bytes of all layers and waits for the device. `target` has the size and the layers of the
  /// picture, a format of as many bytes a pixel, and the layout of a colour attachment, which it keeps.
  void copy_to(vk::Image target) const;

 private:
  const gpu::Device& device_;
  const gpu::Image& shown_;
  vk::raii::CommandBuffer commands_{nullptr};
  vk::raii::Fence fence_{nullptr};
};

}  // namespace farshade::openxr
