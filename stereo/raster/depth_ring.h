/// DepthRing: the depth of the views that masks were requested for. A mask that comes later is compared with
/// it, to find out what surface each of its pixels belongs to. One more place holds the depth of the shown
/// views, for frames whose shown and requested views differ.
#pragma once

#include <optional>
#include <vector>

#include "stereo/frame/frame_id.h"
#include "stereo/frame/view.h"
#include "stereo/gpu/memory.h"

namespace farshade {

class DepthRing {
 public:
  /// Has `slots` places for the views of requests, each up to `size` pixels an eye.
  DepthRing(const gpu::Device& device, Extent size, std::uint32_t slots);

  /// The layers of both eyes.
  struct Place {
    std::uint32_t layer = 0;  ///< of the left eye; the right eye has the next one
    vk::ImageView view;
  };
  /// The place of a request's depth. Whoever owns the request records (stereo/answers/assembler.h) chooses
  /// the slot; the depth that it held before is lost. No value if the ring has no such slot.
  std::optional<Place> claim(FrameId frame, std::size_t slot);
  /// Empties all slots.
  void forget();
  [[nodiscard]] Place shown() const { return place(slots_.size() - 1); }
  [[nodiscard]] bool has(FrameId frame) const { return slot_of(frame).has_value(); }
  /// The layer of a frame that the ring has.
  [[nodiscard]] std::uint32_t layer_of(FrameId frame) const;

  [[nodiscard]] const gpu::Image& image() const { return image_; }
  [[nodiscard]] Extent size() const { return image_.spec.size; }

 private:
  struct Slot {
    std::optional<FrameId> frame;
    vk::raii::ImageView view{nullptr};
  };
  [[nodiscard]] std::optional<std::size_t> slot_of(FrameId frame) const;
  [[nodiscard]] Place place(std::size_t slot) const;

  gpu::Image image_;
  std::vector<Slot> slots_;  ///< the last one is that of the shown views and holds no request
};

}  // namespace farshade
