/// Oracle: the definition of a mask bit (stereo/tracer/tracer.h) in double precision and as plainly as it can
/// be said. It shares no code with the tracer. Beside each bit it says whether that bit lies in the band:
/// where float may rightly disagree with double.
#pragma once

#include "stereo/frame/eye_mask.h"
#include "stereo/frame/view.h"
#include "stereo/scene/scene_state.h"

namespace farshade::oracle {

/// The band of a pixel-light: at the corners of a square about the pixel's centre its value is another, or
/// the seen surface does not go on there (another instance, nothing, or off the pixel's tangent plane by more
/// than half the distance); or the light stands within kGrazing of the pixel's own surface or shading plane.
inline constexpr double kBandRadius_px = 1.0 / 16;
inline constexpr double kGrazing = 1e-5;  ///< sine of an angle

struct Masks {
  Extent size;
  std::uint32_t lights = 0;
  std::vector<std::uint8_t> covered;       ///< a pixel
  std::vector<std::uint8_t> lit, in_band;  ///< a pixel-light, lights of a pixel together

  [[nodiscard]] std::size_t pixel(std::uint32_t x, std::uint32_t y) const {
    return std::size_t{y} * size.width + x;
  }
  [[nodiscard]] std::size_t at(std::uint32_t x, std::uint32_t y, std::uint32_t light) const {
    return pixel(x, y) * lights + light;
  }
};

/// How surfaces are searched: one by one, or through a median-split tree that must find the same.
enum class Search { Brute, Tree };

[[nodiscard]] Masks trace(const Scene& scene, const SceneState& state, const View& view,
                          Search search = Search::Tree);

/// What a mask under test looks like against the oracle.
struct Agreement {
  std::uint64_t pixel_lights = 0, lit = 0, in_band = 0, wrong_in_band = 0,
                wrong = 0;                                  ///< wrong: outside the band
  std::uint32_t wrong_x = 0, wrong_y = 0, wrong_light = 0;  ///< the last of them

  [[nodiscard]] double band_share() const {
    return pixel_lights == 0 ? 0 : static_cast<double>(in_band) / static_cast<double>(pixel_lights);
  }
};

/// Sizes and light counts must agree.
[[nodiscard]] Agreement compare(const EyeMask& mask, const Masks& truth);

}  // namespace farshade::oracle
