/// Measure: how wrong a shown frame was, against the full trace at the pose shown.
#pragma once

#include <limits>
#include <optional>

#include "stereo/draw/renderer.h"
#include "stereo/frame/pose_delta.h"

namespace farshade {

/// One eye of one frame. Shares and errors are over covered pixels x lights; the five shares add up to 1.
/// Where the mode shows a picture of a server's, lights cannot be told apart in it: they are kNotMeasured.
struct EyeErrors {
  double mask_error = 0;                ///< mean of |k shown - k reference|
  double known_error = 0;               ///< the same among those that are not unknown
  double psnr_db = 0;                   ///< of the shown sRGB picture; infinite if equal
  double newest = 0;                    ///< share from this eye's newest mask
  double other_eye = 0;                 ///< from the other eye's newest mask
  double older = 0;                     ///< from older masks of either
  double neighbours = 0;                ///< from the nearest pixel on the same surface
  double unknown = 0;                   ///< shown by the rule
  double stale = 0;                     ///< of all: known, but something has moved since
  std::optional<double> unmoved_error;  ///< mask error, had the newest mask been shown as it was traced
};

inline constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

/// Of a picture of which nothing but the PSNR can be told.
[[nodiscard]] inline EyeErrors picture_errors(double psnr_db) {
  return {.mask_error = kNotMeasured,
          .known_error = kNotMeasured,
          .psnr_db = psnr_db,
          .newest = kNotMeasured,
          .other_eye = kNotMeasured,
          .older = kNotMeasured,
          .neighbours = kNotMeasured,
          .unknown = kNotMeasured,
          .stale = kNotMeasured,
          .unmoved_error = std::nullopt};
}

/// `shown` as reported by the shading pass, `reference` traced for the same view.
/// psnr_db and unmoved_error are left to the caller.
[[nodiscard]] EyeErrors compare_masks(const ShownReport& shown, const EyeMask& reference);

/// Mask error of `stale` read at the shown pixels themselves, whose grid begins `offset_px` into it, over the
/// pixels that `shown` covers; what lies outside of it is shown by the rule.
[[nodiscard]] double unmoved_error(const EyeMask& stale, glm::ivec2 offset_px, const ShownReport& shown,
                                   const EyeMask& reference);

/// Pixels in one degree at the middle of the view, as FLIP asks for it.
[[nodiscard]] double pixels_per_degree(const View& view);

}  // namespace farshade
