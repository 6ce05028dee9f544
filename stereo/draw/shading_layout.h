/// How what the shading pass reads and writes lies in memory, and how much there is of it. Pure; the pass and
/// the prediction of its memory go by the same figures.
#pragma once

#include "shaders/shared.h"
#include "stereo/draw/mask_edges.h"
#include "stereo/plan/scene_plan.h"

namespace farshade {

/// Masks are carried over from the views they were traced for to others; else they are read at the pixel.
[[nodiscard]] constexpr bool carries_masks(const DrawPlan& plan) {
  return plan.depth_pass && plan.mask.lights > 0;
}

/// `plan` without what only serves carrying masks over, where none are.
[[nodiscard]] DrawPlan settled(DrawPlan plan);

/// A mask as the device holds it: with the bits that say where edges pass, if anybody asks for them.
[[nodiscard]] constexpr MaskLayout device_mask(const DrawPlan& plan) {
  return carries_masks(plan) ? with_edge_bits(plan.mask) : plan.mask;
}

/// Masks that the device holds.
[[nodiscard]] constexpr std::size_t most_masks(const DrawPlan& plan) {
  return plan.mask.lights == 0 ? 0 : carries_masks(plan) ? FARSHADE_MAX_MASKS : 1;
}

/// What one pixel's report is made of, in words, as shade.comp writes it.
struct ReportLayout {
  explicit ReportLayout(MaskLayout mask)
      : visibility(3),
        unknown(3 + (mask.lights + 3) / 4),
        stale(unknown + planes(mask)),
        beside(stale + planes(mask)),
        words(beside + planes(mask)) {}

  std::size_t visibility, unknown, stale, beside, words;

 private:
  /// Without lights shade.comp has no planes.
  static std::size_t planes(MaskLayout mask) { return (mask.lights + 31) / 32; }
};

/// Bytes of the pass's buffers.
struct ShadingBytes {
  std::size_t lights = 0;
  std::size_t mask = 0, known = 0;     ///< one eye's mask and which of its tiles are known: whole words
  std::size_t slots = 0, motions = 0;  ///< 0 where nothing moves
  std::size_t lists = 0;               ///< 0 where masks are read at the pixel
  std::size_t report = 0;              ///< once it is asked for
};
/// For eyes of `size` and masks of up to `traced_size` pixels.
[[nodiscard]] ShadingBytes shading_bytes(const DrawPlan& plan, Extent size, Extent traced_size);

}  // namespace farshade
