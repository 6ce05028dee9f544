/// DepthSlots: which place holds the depth of which request. Places are numbered as they are first needed. A
/// request has the slot of its record (stereo/answers/assembler.h), and the slot has a place only while a
/// mask may still be used with the depth there. So the number of places follows the latency of the answers.
/// Pure; no device needed.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "stereo/frame/traced_mask.h"

namespace farshade {

class DepthSlots {
 public:
  explicit DepthSlots(std::size_t slots) : slots_(slots) {}

  /// The place for the depth of a request; the depth that its slot held before is lost. A place without
  /// depth is used again before a new one gets a number. No value if there is no such slot.
  std::optional<std::size_t> claim(FrameId frame, std::size_t slot);

  /// Gives back the place of a request that got no depth.
  void release(FrameId frame);

  /// The place with the depth of this request; no value if there is none.
  [[nodiscard]] std::optional<std::size_t> find(FrameId frame) const;

  /// `masks` are those that a frame may use, in the order of trust; it uses the first `most` that have depth.
  /// Gives back the depth of requests that are older than all of these. No later frame can use it: its masks
  /// are these and newer ones, because the assembler evicts the oldest first.
  void give_back_unused(std::span<const TracedMask> masks, std::size_t most);

  /// Empties all slots.
  void forget();

  /// The number of places.
  [[nodiscard]] std::size_t places() const { return places_; }

 private:
  struct Slot {
    std::optional<FrameId> frame;
    std::size_t place = 0;
  };
  void give_back(Slot& slot);

  std::vector<Slot> slots_;
  std::vector<std::size_t> free_;  ///< places without depth
  std::size_t places_ = 0;
};

}  // namespace farshade
