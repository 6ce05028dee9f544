#include "vr_client/report/measure.h"

#include <bit>

namespace farshade {
namespace {

/// Sum of |k shown - k reference| over the lights of one pixel.
double pixel_error(const ShownReport& shown, const EyeMask& reference, std::uint32_t x, std::uint32_t y,
                   std::uint8_t source) {
  double error = 0;
  const MaskLayout layout = reference.layout();
  for (std::uint32_t plane = 0; plane < layout.planes(); ++plane) {
    const std::uint32_t truth = reference.word(x, y, plane);
    if (source == kSourceUnknown) {
      const int lit = std::popcount(truth), dark = static_cast<int>(layout.lights_in(plane)) - lit;
      error += lit * (1.0 - double{kUnknownVisibility}) + dark * double{kUnknownVisibility};
    } else {
      error += std::popcount(truth ^ shown.mask.word(x, y, plane));
    }
  }
  return error;
}

}  // namespace

EyeErrors compare_masks(const ShownReport& shown, const EyeMask& reference) {
  EyeErrors errors;
  std::uint64_t covered = 0, newest = 0, unknown = 0;
  double sum = 0;
  const Extent size = reference.size();
  for (std::uint32_t y = 0; y < size.height; ++y)
    for (std::uint32_t x = 0; x < size.width; ++x) {
      const std::uint8_t source = shown.sources[std::size_t{y} * size.width + x];
      if (source == kSourceUncovered) continue;
      ++covered;
      newest += source == 0;
      unknown += source == kSourceUnknown;
      sum += pixel_error(shown, reference, x, y, source);
    }
  if (covered == 0 || reference.lights() == 0) return errors;
  const auto total = static_cast<double>(covered);
  errors.mask_error = sum / (total * reference.lights());
  errors.newest = static_cast<double>(newest) / total;
  errors.unknown = static_cast<double>(unknown) / total;
  errors.older = static_cast<double>(covered - newest - unknown) / total;
  return errors;
}

}  // namespace farshade
