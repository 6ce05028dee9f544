#include "vr_client/openxr/picture_copy.h"

#include "stereo/frame/view.h"

namespace farshade::openxr {
namespace {

void record(const vk::raii::CommandBuffer& commands, const LayerCopy& copy, Extent size) {
  using Layout = vk::ImageLayout;
  constexpr auto eyes = static_cast<std::uint32_t>(kEyes);
  const gpu::LayerRange from{copy.first_layer, eyes}, to{0, eyes};
  const vk::ImageAspectFlags aspect = copy.from.aspect;
  gpu::transition(commands, copy.from, copy.from_layout, Layout::eTransferSrcOptimal, from);
  gpu::transition(commands, copy.to, Layout::eUndefined, Layout::eTransferDstOptimal, to, aspect);
  commands.copyImage(*copy.from.image, Layout::eTransferSrcOptimal, copy.to, Layout::eTransferDstOptimal,
                     vk::ImageCopy{.srcSubresource = {aspect, 0, from.first, from.count},
                                   .dstSubresource = {aspect, 0, to.first, to.count},
                                   .extent = {size.width, size.height, 1}});
  gpu::transition(commands, copy.to, Layout::eTransferDstOptimal, copy.to_layout, to, aspect);
  gpu::transition(commands, copy.from, Layout::eTransferSrcOptimal, copy.from_layout, from);
}

}  // namespace

void record_copies(const vk::raii::CommandBuffer& commands, std::span<const LayerCopy> copies, Extent size) {
  for (const LayerCopy& one : copies) record(commands, one, size);
}

}  // namespace farshade::openxr
