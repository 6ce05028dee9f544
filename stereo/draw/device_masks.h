/// DeviceMasks: the masks that the device holds, each with its edge bits (mask_edges.h) and its known blocks.
/// The passes that read masks share them. A mask that stays in use is copied to the device once.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "stereo/draw/carry_over.h"
#include "stereo/draw/mask_slots.h"
#include "stereo/draw/shading_layout.h"
#include "stereo/gpu/memory.h"

namespace farshade {

class DeviceMasks {
 public:
  /// Room for most_masks(plan) masks of `bytes`. Keeps the reference.
  DeviceMasks(const gpu::Device& device, const DrawPlan& plan, const ShadingBytes& bytes);

  /// Where a mask lies.
  struct Held {
    std::size_t slot = 0;
    bool whole = false;  ///< every block is known
  };
  /// Copies to the device what it does not hold yet. Their frames are distinct. The result is valid until the
  /// next call.
  std::vector<Held> hold(std::span<const TracedMask* const> masks);

  /// SourceData::place of an eye's mask. `layer` has the depth of the left eye's view.
  [[nodiscard]] glm::uvec4 place(const Held& held, std::size_t eye, std::size_t layer) const;

  /// Forgets all masks, because frame ids begin anew.
  void forget() { slots_.clear(); }

  [[nodiscard]] const gpu::Buffer& words() const { return words_; }
  [[nodiscard]] const gpu::Buffer& known_blocks() const { return known_; }
  [[nodiscard]] std::uint64_t uploads() const { return uploads_; }

 private:
  [[nodiscard]] bool upload(std::size_t slot, const TracedMask& mask) const;

  const DrawPlan& plan_;
  std::size_t mask_bytes_, known_bytes_;  ///< of one eye
  gpu::Buffer words_, known_;
  MaskSlots slots_;
  std::array<bool, kMaxMasks> is_whole_{};  ///< by slot
  std::uint64_t uploads_ = 0;
};

}  // namespace farshade
