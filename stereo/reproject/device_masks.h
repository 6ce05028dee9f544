/// DeviceMasks: the masks that the device holds, each with its edge bits, its cells (mask_edges.h) and its
/// known blocks. The passes that read masks share them. A mask that stays in use is copied to the device
/// once.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "stereo/gpu/upload_buffer.h"
#include "stereo/reproject/mask_edges.h"
#include "stereo/reproject/mask_slots.h"
#include "stereo/reproject/reprojection.h"
#include "stereo/reproject/shading_layout.h"

namespace farshade {

class DeviceMasks {
 public:
  /// Room for most_masks(plan) masks of views and most_cube_mask_pairs(plan) masks of the cube's faces. Keeps
  /// the references.
  DeviceMasks(gpu::FramesInFlight& frames, const DrawPlan& plan, const ShadingBytes& bytes);

  enum class Kind : std::uint8_t { Views, CubeMask };

  /// Where a mask lies.
  struct Held {
    Kind kind = Kind::Views;
    std::size_t slot = 0;
    bool whole = false;  ///< every block is known
  };
  /// Copies to the device what it does not hold yet. Their frames are distinct. The result is valid until the
  /// next call with the same kind.
  std::vector<Held> hold(Kind kind, std::span<const TracedMask* const> masks);

  /// SourceData::place of an eye's mask. `layer` has the depth of the left eye's view.
  [[nodiscard]] glm::uvec4 place(const Held& held, std::size_t eye, std::size_t layer) const;

  /// Cells of masks of views have edges near thin shadows of these lights, to which edge rays can be traced.
  /// When they change, masks are copied again.
  void set_ray_lights(const LightBits& lights);

  /// Forgets all masks, because frame ids begin anew.
  void forget();

  [[nodiscard]] const gpu::UploadBuffer& words() const { return words_; }
  [[nodiscard]] const gpu::UploadBuffer& known_blocks() const { return known_; }
  [[nodiscard]] std::uint64_t uploads() const { return uploads_; }

 private:
  /// The masks of one kind.
  struct Shelf {
    MaskBytes bytes;           ///< of one eye
    std::size_t words, known;  ///< where the shelf begins in the buffers, bytes
    MaskSlots slots;
    std::vector<bool> is_whole;  ///< by slot
  };
  [[nodiscard]] bool upload(Kind kind, std::size_t slot, const TracedMask& mask);
  [[nodiscard]] const Shelf& shelf(Kind kind) const { return shelves_[static_cast<std::size_t>(kind)]; }

  const DrawPlan& plan_;
  gpu::UploadBuffer words_, known_;
  std::array<Shelf, 2> shelves_;
  LightBits ray_lights_{};
  std::uint64_t uploads_ = 0;
};

}  // namespace farshade
