#include "stereo/gpu/upload_buffer.h"

#include <algorithm>

namespace farshade::gpu {

UploadBuffer make_upload_buffer(FramesInFlight& frames, std::size_t bytes, vk::BufferUsageFlags usage,
                                const std::string& name, Use use) {
  return {frames, make_device_buffer(frames.device(), bytes, usage | vk::BufferUsageFlagBits::eTransferDst,
                                     name, use)};
}

/// Parts that follow each other in both memories become one copy.
WriteOnly<std::byte> UploadBuffer::part(std::size_t first, std::size_t bytes) {
  check(first <= device_.bytes && bytes <= device_.bytes - first, "a view lies in its buffer");
  if (bytes == 0) return {};
  if (first < end_) forget(first, first + bytes);
  end_ = std::max(end_, first + bytes);
  if (!written_.empty() && written_.back().end() == first && frames_->grow(written_.back().memory, bytes)) {
    const HostMemory& all = written_.back().memory;
    return HostMemory{all.buffer, all.offset + all.bytes - bytes, bytes}.view();
  }
  written_.push_back({first, frames_->take(bytes)});
  return written_.back().memory.view();
}

/// What was written to these bytes is not copied.
void UploadBuffer::forget(std::size_t first, std::size_t end) {
  std::vector<Written> kept;
  const auto keep = [&](const Written& one, std::size_t from, std::size_t to) {
    const HostMemory& all = one.memory;
    if (from < to) kept.push_back({from, {all.buffer, all.offset + (from - one.first), to - from}});
  };
  for (const Written& one : written_) {
    keep(one, one.first, std::min(one.end(), first));
    keep(one, std::max(one.first, end), one.end());
  }
  written_ = std::move(kept);
}

void UploadBuffer::record_copies(const vk::raii::CommandBuffer& commands) const {
  for (auto from = written_.begin(); from != written_.end();) {
    const std::shared_ptr<const StagingBuffer> memory = from->memory.buffer;
    std::vector<vk::BufferCopy> copies;
    for (; from != written_.end() && from->memory.buffer == memory; ++from)
      copies.push_back(
          {.srcOffset = from->memory.offset, .dstOffset = from->first, .size = from->memory.bytes});
    commands.copyBuffer(*memory->buffer, *device_.buffer, copies);
    frames_->keep(memory);
  }
  written_.clear();
  end_ = 0;
}

void record_uploads(const vk::raii::CommandBuffer& commands, std::span<const UploadBuffer* const> buffers) {
  using At = vk::PipelineStageFlagBits2;
  using Access = vk::AccessFlagBits2;
  const auto barrier = [&](vk::PipelineStageFlags2 from, vk::AccessFlags2 written, vk::PipelineStageFlags2 to,
                           vk::AccessFlags2 accessed) {
    const vk::MemoryBarrier2 memory{
        .srcStageMask = from, .srcAccessMask = written, .dstStageMask = to, .dstAccessMask = accessed};
    commands.pipelineBarrier2({.memoryBarrierCount = 1, .pMemoryBarriers = &memory});
  };
  if (std::ranges::all_of(buffers, [](const UploadBuffer* buffer) { return buffer->written_.empty(); }))
    return;
  barrier(At::eAllCommands, Access::eMemoryWrite, At::eTransfer, Access::eTransferWrite);
  for (const UploadBuffer* buffer : buffers) buffer->record_copies(commands);
  barrier(At::eTransfer, Access::eTransferWrite, At::eAllCommands,
          Access::eMemoryRead | Access::eMemoryWrite);
}

}  // namespace farshade::gpu
