/// MaskSlots: which mask lies in which of the device's mask slots. A mask that stays in use keeps its slot,
/// so that it is copied to the device once. Pure; no device needed.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "stereo/frame/frame_id.h"

namespace farshade {

/// Identifies the bits of a mask. `content` changes whenever the bits do.
struct MaskVersion {
  FrameId frame;
  std::uint64_t content = 0;
};

class MaskSlots {
 public:
  explicit MaskSlots(std::size_t count) : slots_(count) {}

  struct Assignment {
    std::size_t slot = 0;
    bool must_upload = false;  ///< the slot does not hold this version yet
  };
  /// A slot for each mask of a frame. The frames of `masks` are distinct, and there are at most as many as
  /// slots. A mask that has a slot keeps it. A new mask gets the least recently used of the other slots.
  [[nodiscard]] std::vector<Assignment> assign(std::span<const MaskVersion> masks);

  /// Empties all slots.
  void clear();

 private:
  struct Slot {
    std::optional<FrameId> frame;
    std::uint64_t content = 0;
    std::uint64_t last_use = 0;  ///< number of the `assign` call
  };
  std::vector<Slot> slots_;
  std::uint64_t calls_ = 0;
};

}  // namespace farshade
