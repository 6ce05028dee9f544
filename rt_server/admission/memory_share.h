/// MemoryShare: how much memory clients may make the server hold. Half of the limit is for what waits: the
/// sessions, the parts of requests and the datagrams of answers. Half of that is divided among the keys, so
/// that other keys, however many work together, cannot take it; the other half goes to whoever comes first.
/// One key of several has at most half of what waits. The second half of the limit is for the answer in the
/// making, of which there is one.
#pragma once

#include <cstdint>

#include "stereo/frame/shadow_frame.h"

namespace farshade {

/// Enough for the positions of 64 sessions (kMostParts_bytes each) of one key, and for the pictures of two
/// views of 2,000 x 2,000 pixels.
inline constexpr std::size_t kMemory_bytes = std::size_t{2} << 30;

struct MemoryShare {
  std::size_t limit_bytes = kMemory_bytes;

  /// For all that waits.
  [[nodiscard]] std::size_t waiting() const { return limit_bytes / 2; }
  /// For what waits for one key of `keys`.
  [[nodiscard]] std::size_t of_key(std::size_t keys) const { return keys > 1 ? waiting() / 2 : waiting(); }
  /// Of `waiting()`, what no other of `keys` can take from a key.
  [[nodiscard]] std::size_t guaranteed(std::size_t keys) const {
    return keys > 1 ? waiting() / 2 / keys : waiting();
  }
  [[nodiscard]] std::size_t in_work() const { return limit_bytes / 2; }
};

/// Assumed memory of a renderer, of a pixel that it draws.
inline constexpr std::size_t kDrawnPixel_bytes = 64;

/// An upper estimate of the memory that making the answer takes: masks of `lights` lights and their messages,
/// positions, the renderer, and as much for the picture that is read back and coded.
[[nodiscard]] inline std::size_t answer_bytes(const FrameRequest& request, std::uint32_t lights) {
  constexpr std::size_t kPositions_bytes = 12;  // of a pixel
  // An LZ4 block takes a copy of the masks, too, and its own bytes.
  const std::size_t copies = request.answer.coding == Coding::Lz4 ? 4 : 2;
  std::size_t per_pixel = copies * ((std::size_t{lights} + 7) / 8);
  if (request.answer.kind == Answer::MasksOfPositions) per_pixel += kPositions_bytes;
  if (is_drawn(request.answer.kind)) per_pixel += 2 * kDrawnPixel_bytes;
  return (request.views[0].size.pixels() + request.views[1].size.pixels()) * per_pixel;
}

}  // namespace farshade
