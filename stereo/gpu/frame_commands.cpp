#include "stereo/gpu/frame_commands.h"

#include <algorithm>

namespace farshade::gpu {

void wait_for_earlier(const vk::raii::CommandBuffer& commands) {
  const vk::MemoryBarrier2 all{
      .srcStageMask = vk::PipelineStageFlagBits2::eAllCommands,
      .srcAccessMask = vk::AccessFlagBits2::eMemoryWrite,
      .dstStageMask = vk::PipelineStageFlagBits2::eAllCommands,
      .dstAccessMask = vk::AccessFlagBits2::eMemoryRead | vk::AccessFlagBits2::eMemoryWrite};
  commands.pipelineBarrier2({.memoryBarrierCount = 1, .pMemoryBarriers = &all});
}

FrameCommands::FrameCommands(const Device& device) : device_(device) {
  if (!device.timelines) return;
  const vk::SemaphoreTypeCreateInfo timeline{.semaphoreType = vk::SemaphoreType::eTimeline};
  finished_ = device.logical.createSemaphore({.pNext = &timeline});
}

FrameCommands::~FrameCommands() {
  try {
    if (!is_lost_) wait(submitted_);
  } catch (const vk::SystemError&) {
    // The device is abandoned or lost; whoever used it next is told.
  }
}

/// One whose part has finished, or a new one.
FrameCommands::Buffer& FrameCommands::free_buffer() {
  const auto free = std::ranges::find_if(buffers_, [&](const Buffer& one) { return one.part <= known_; });
  if (free != buffers_.end()) return *free;
  auto commands = device_.logical.allocateCommandBuffers(
      {.commandPool = *device_.commands, .level = vk::CommandBufferLevel::ePrimary, .commandBufferCount = 1});
  Buffer made{.commands = std::move(commands[0])};
  if (!device_.timelines) made.fence = device_.logical.createFence({});
  return buffers_.emplace_back(std::move(made));
}

FrameCommands::Part FrameCommands::record(const Recording& record) {
  Buffer& buffer = free_buffer();
  buffer.commands.reset();
  buffer.commands.begin({.flags = vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
  wait_for_earlier(buffer.commands);
  record(buffer.commands);
  buffer.commands.end();
  buffer.part = ++newest_;
  return newest_;
}

void FrameCommands::submit() {
  if (submitted_ == newest_) return;
  losing_device([&] { device_.timelines ? submit_together() : submit_apart(); });
  submitted_ = newest_;
}

/// The parts that are not submitted yet, in their order.
std::vector<const FrameCommands::Buffer*> FrameCommands::recorded() const {
  std::vector<const Buffer*> parts;
  for (const Buffer& buffer : buffers_)
    if (buffer.part > submitted_) parts.push_back(&buffer);
  std::ranges::sort(parts, {}, &Buffer::part);
  return parts;
}

/// Each part says when it has finished.
void FrameCommands::submit_together() {
  const std::vector<const Buffer*> parts = recorded();
  std::vector<vk::CommandBufferSubmitInfo> buffers;
  std::vector<vk::SemaphoreSubmitInfo> signals;
  for (const Buffer* part : parts) {
    buffers.push_back({.commandBuffer = *part->commands});
    signals.push_back({.semaphore = *finished_,
                       .value = part->part,
                       .stageMask = vk::PipelineStageFlagBits2::eAllCommands});
  }
  std::vector<vk::SubmitInfo2> submits;
  for (std::size_t i = 0; i < parts.size(); ++i)
    submits.push_back({.commandBufferInfoCount = 1,
                       .pCommandBufferInfos = &buffers[i],
                       .signalSemaphoreInfoCount = 1,
                       .pSignalSemaphoreInfos = &signals[i]});
  ++device_.use->submissions;
  device_.queue.submit2(submits);
}

/// A submission has one fence, so each part is one.
void FrameCommands::submit_apart() {
  for (const Buffer* part : recorded()) {
    const vk::CommandBufferSubmitInfo buffer{.commandBuffer = *part->commands};
    device_.logical.resetFences(*part->fence);
    ++device_.use->submissions;
    device_.queue.submit2(vk::SubmitInfo2{.commandBufferInfoCount = 1, .pCommandBufferInfos = &buffer},
                          *part->fence);
  }
}

bool FrameCommands::finishes(Part part) const {
  return finishes_in_time(device_, [&](std::uint64_t step_ns) {
    if (!device_.timelines)
      return device_.logical.waitForFences(*std::ranges::find(buffers_, part, &Buffer::part)->fence, true,
                                           step_ns);
    return device_.logical.waitSemaphores({.semaphoreCount = 1, .pSemaphores = &*finished_, .pValues = &part},
                                          step_ns);
  });
}

void FrameCommands::wait(Part part) {
  if (part > submitted_) submit();
  if (part <= known_) return;
  ++device_.use->waits;
  is_lost_ = true;  // unless what follows returns
  losing_device([&] {
    if (!finishes(part)) {
      abandon(device_);
      throw vk::DeviceLostError("the device did not finish in time and was abandoned");
    }
    known_ = part;
  });
  is_lost_ = false;
}

}  // namespace farshade::gpu
