#include "stereo/raster/depth_ring.h"

#include "stereo/gpu/device.h"
#include "stereo/raster/scene_pass.h"

namespace farshade {

gpu::Image make_depth_image(const gpu::Device& device, Extent size, std::size_t pairs,
                            const std::string& name) {
  return gpu::make_image(
      device,
      {.size = size,
       .layers = narrow<std::uint32_t>(kEyes * pairs),
       .format = kDepthFormat,
       .usage = vk::ImageUsageFlagBits::eDepthStencilAttachment | vk::ImageUsageFlagBits::eTransferSrc |
                vk::ImageUsageFlagBits::eTransferDst | vk::ImageUsageFlagBits::eSampled,
       .use = gpu::Use::Depth},
      name);
}

DepthPlace made_readable(const gpu::Device& device, const gpu::Image& image) {
  gpu::run_now(device, [&](const vk::raii::CommandBuffer& commands) {
    gpu::transition(commands, image, vk::ImageLayout::eUndefined, vk::ImageLayout::eShaderReadOnlyOptimal);
  });
  return {&image, 0, *image.view};
}

DepthRing::DepthRing(const gpu::Device& device, Extent size, std::size_t slots, DepthImages images)
    : device_(device),
      size_(size),
      slots_(slots),
      places_per_image_(images == DepthImages::Shared ? slots : 1) {
  if (images == DepthImages::Shared)
    static_cast<void>(
        made_readable(device, images_.emplace_back(make_depth_image(device, size, slots, "shared depth"))));
}

DepthPlace DepthRing::place(std::size_t number) const {
  return {&images_[number / places_per_image_], narrow<std::uint32_t>(number % places_per_image_ * kEyes),
          *views_[number]};
}

std::optional<DepthPlace> DepthRing::claim(FrameId frame, std::size_t slot) {
  const std::optional<std::size_t> number = slots_.claim(frame, slot);
  if (!number) return std::nullopt;
  try {
    while (images_.size() <= *number / places_per_image_)
      images_.push_back(make_depth_image(device_, size_, places_per_image_, "depth of a request"));
  } catch (const vk::OutOfDeviceMemoryError&) {
    slots_.release(frame);
    if (images_.empty()) throw;
    return std::nullopt;
  }
  while (views_.size() <= *number) {
    const gpu::LayerRange layers{narrow<std::uint32_t>(views_.size() % places_per_image_ * kEyes), kEyes};
    views_.push_back(gpu::view_layers(device_, images_[views_.size() / places_per_image_], layers));
  }
  return place(*number);
}

DepthPlace DepthRing::place_of(FrameId frame) const {
  const std::optional<std::size_t> number = slots_.find(frame);
  check(number.has_value(), "the ring has the depth of the frame");
  return place(*number);
}

}  // namespace farshade
