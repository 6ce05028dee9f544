/// DepthRing: the depth of the views that masks were requested for. A mask that comes later is compared with
/// it, to find out what surface each of its pixels belongs to.
#pragma once

#include <deque>
#include <optional>

#include "stereo/frame/view.h"
#include "stereo/gpu/memory.h"
#include "stereo/raster/depth_slots.h"

namespace farshade {

/// The images of a ring: one for each request that a mask may still come for, made when it is first needed,
/// because one image for all could be larger than a device allows; or one for all, made at once.
enum class DepthImages : std::uint8_t { Single, Shared };

/// Two layers of an image that hold the depth of two views. `image` stays at its address.
struct DepthPlace {
  const gpu::Image* image = nullptr;
  std::uint32_t layer = 0;  ///< of the left eye; the right eye has the next one
  vk::ImageView view;       ///< of both layers
};

class DepthRing {
 public:
  /// Has places for at most `slots` requests, each for views of up to `size` pixels an eye. Keeps the
  /// reference.
  DepthRing(const gpu::Device& device, Extent size, std::size_t slots, DepthImages images);

  /// The place of a request's depth. Whoever owns the request records (stereo/answers/assembler.h) chooses
  /// the slot; the depth that it held before is lost. No value if the ring has no such slot, or the device
  /// has no memory for another image. Throws if it has none for the first.
  std::optional<DepthPlace> claim(FrameId frame, std::size_t slot);
  /// See DepthSlots. The depth is not overwritten before a later `claim`.
  void give_back_unused(std::span<const TracedMask> masks, std::size_t most) {
    slots_.give_back_unused(masks, most);
  }
  /// Gives back the place of a request whose depth was not drawn.
  void release(FrameId frame) { slots_.release(frame); }
  /// Empties all slots.
  void forget() { slots_.forget(); }
  [[nodiscard]] bool has(FrameId frame) const { return slots_.find(frame).has_value(); }
  /// The place of a frame that the ring has.
  [[nodiscard]] DepthPlace place_of(FrameId frame) const;

  /// Those that exist.
  [[nodiscard]] const std::deque<gpu::Image>& images() const { return images_; }

 private:
  [[nodiscard]] DepthPlace place(std::size_t number) const;

  const gpu::Device& device_;
  Extent size_;
  DepthSlots slots_;
  std::size_t places_per_image_;
  std::deque<gpu::Image> images_;           ///< a deque keeps their addresses
  std::vector<vk::raii::ImageView> views_;  ///< of each place
};

/// An image for the depth of `pairs` pairs of views.
[[nodiscard]] gpu::Image make_depth_image(const gpu::Device& device, Extent size, std::size_t pairs,
                                          const std::string& name);
/// The first two layers of an image. Makes the whole image readable by shaders; its contents are undefined.
[[nodiscard]] DepthPlace made_readable(const gpu::Device& device, const gpu::Image& image);

}  // namespace farshade
