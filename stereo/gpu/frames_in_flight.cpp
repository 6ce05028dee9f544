#include "stereo/gpu/frames_in_flight.h"

#include <algorithm>

namespace farshade::gpu {
namespace {

constexpr std::size_t kChunk_bytes = 256 << 10, kAlignment_bytes = 16;

constexpr std::size_t aligned(std::size_t bytes) {
  return (bytes + kAlignment_bytes - 1) / kAlignment_bytes * kAlignment_bytes;
}

}  // namespace

FramesInFlight::FramesInFlight(const Device& device, std::size_t count) : device_(device), frames_(count) {
  check(count > 0, "at least one frame exists");
}

void FramesInFlight::next() {
  place_ = next_place();
  clear(frames_[place_]);
}

void FramesInFlight::restart() {
  clear(frames_[place_]);
}

/// A frame that needed several chunks gets one chunk. A chunk of which a part must still be copied leaves the
/// frame: the UploadBuffer holds it.
void FramesInFlight::clear(Frame& frame) {
  frame.kept.clear();
  std::erase_if(frame.chunks, [](const Chunk& chunk) { return chunk.buffer.use_count() > 1; });
  const std::size_t bytes = bytes_of(frame);
  if (frame.chunks.size() > 1) {
    frame.chunks.clear();
    frame.chunks.push_back(make_chunk(bytes));
  }
  for (Chunk& chunk : frame.chunks) chunk.used = 0;
}

std::size_t FramesInFlight::bytes_of(const Frame& frame) {
  std::size_t bytes = 0;
  for (const Chunk& chunk : frame.chunks) bytes += chunk.buffer->bytes;
  return bytes;
}

FramesInFlight::Chunk FramesInFlight::make_chunk(std::size_t bytes) const {
  return {std::make_shared<StagingBuffer>(
      make_staging_buffer(device_, bytes, "uploads of a frame", Use::Uploads))};
}

HostMemory FramesInFlight::take(std::size_t bytes) {
  std::vector<Chunk>& chunks = frames_[place_].chunks;
  const std::size_t rounded = aligned(bytes);
  auto with_room = std::ranges::find_if(
      chunks, [&](const Chunk& chunk) { return chunk.buffer->bytes - chunk.used >= rounded; });
  if (with_room == chunks.end())  // at least doubles the memory, so that there are few chunks
    with_room =
        chunks.insert(chunks.end(), make_chunk(std::max({rounded, kChunk_bytes, bytes_of(frames_[place_])})));
  return {with_room->buffer, std::exchange(with_room->used, with_room->used + rounded), bytes};
}

bool FramesInFlight::grow(HostMemory& memory, std::size_t bytes) {
  std::vector<Chunk>& chunks = frames_[place_].chunks;
  const auto chunk = std::ranges::find(chunks, memory.buffer, &Chunk::buffer);
  if (chunk == chunks.end() || memory.offset + memory.bytes != chunk->used) return false;
  if (chunk->buffer->bytes - chunk->used < aligned(bytes)) return false;
  chunk->used += aligned(bytes);
  memory.bytes += bytes;
  return true;
}

}  // namespace farshade::gpu
