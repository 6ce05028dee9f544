/// Measure: how wrong a shown frame was, against the full trace at the pose shown.
#pragma once

#include "vr_client/draw/renderer.h"

namespace farshade {

/// One eye of one frame. Shares are of covered pixel-lights and add up to 1.
struct EyeErrors {
  double mask_error = 0;  ///< mean of |k shown - k reference|
  double psnr_db = 0;     ///< of the shown sRGB picture; infinite if equal
  double newest = 0;      ///< share from the newest mask in hand
  double older = 0;       ///< share from older masks
  double unknown = 0;     ///< share shown by the rule
};

/// `shown` as reported by the shading pass, `reference` traced for the same view.
/// psnr_db is left to the caller, who has the pictures.
[[nodiscard]] EyeErrors compare_masks(const ShownReport& shown, const EyeMask& reference);

}  // namespace farshade
