/// DepthRing: the depths of the views that masks were asked for, so that a mask that comes back later can be
/// tested against what its views saw. One more place holds the shown views' depth, where they were not asked
/// for themselves.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "stereo/frame/frame_id.h"
#include "stereo/frame/view.h"
#include "stereo/gpu/memory.h"

namespace farshade {

class DepthRing {
 public:
  /// Places for the views of `frames` requests, each up to `size` pixels an eye.
  DepthRing(const gpu::Device& device, Extent size, std::uint32_t frames);

  /// Both eyes' layers.
  struct Place {
    std::uint32_t layer = 0;  ///< the left eye's; the right eye's is the next
    vk::ImageView view;
  };
  /// Whether it remembers any request.
  [[nodiscard]] bool remembers() const { return slots_.size() > 1; }
  /// A place for a request that is newer than all before. If none is free, the oldest request that is not
  /// among `kept`, fewer than there are places, loses its depth.
  Place claim(FrameId frame, std::span<const FrameId> kept);
  /// No request's depth is in the ring.
  void forget();
  [[nodiscard]] Place shown() const { return place(slots_.size() - 1); }
  [[nodiscard]] bool has(FrameId frame) const { return slot_of(frame).has_value(); }
  /// A frame that the ring has.
  [[nodiscard]] std::uint32_t layer_of(FrameId frame) const;

  [[nodiscard]] const gpu::Image& image() const { return image_; }
  [[nodiscard]] Extent size() const { return image_.wish.size; }

 private:
  struct Slot {
    std::optional<FrameId> frame;
    vk::raii::ImageView view{nullptr};
  };
  [[nodiscard]] std::optional<std::size_t> slot_of(FrameId frame) const;
  [[nodiscard]] std::size_t room(std::span<const FrameId> kept) const;
  [[nodiscard]] Place place(std::size_t slot) const;

  gpu::Image image_;
  std::vector<Slot> slots_;  ///< the last is the shown views' and holds no request
};

}  // namespace farshade
