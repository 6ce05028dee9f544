/// Oracle: computes mask bits by their definition (stereo/tracer/tracer.h), in double precision and as
/// directly as possible. It shares no code with the tracer. For each bit it also says whether the bit lies in
/// the band, where a tracer in float may correctly differ from double.
#pragma once

#include "stereo/frame/eye_mask.h"
#include "stereo/frame/view.h"
#include "stereo/scene/scene_state.h"

namespace farshade::oracle {

/// A pixel-light lies in the band if one of these conditions holds. At a corner of a square around the
/// pixel's centre, its value differs. At such a corner the visible surface does not continue: there is
/// another instance, or nothing, or the surface is off the pixel's tangent plane by more than half the
/// distance. The direction to the light is within kGrazing of the pixel's surface or of its shading plane.
inline constexpr double kBandRadius_px = 1.0 / 16;  ///< half the side of the square
inline constexpr double kGrazing = 1e-5;            ///< sine of an angle

struct Masks {
  Extent size;
  std::uint32_t lights = 0;
  std::vector<std::uint8_t> covered;       ///< one per pixel
  std::vector<std::uint8_t> lit, in_band;  ///< one per pixel-light, all lights of a pixel in a row

  [[nodiscard]] std::size_t pixel(std::uint32_t x, std::uint32_t y) const {
    return std::size_t{y} * size.width + x;
  }
  [[nodiscard]] std::size_t at(std::uint32_t x, std::uint32_t y, std::uint32_t light) const {
    return pixel(x, y) * lights + light;
  }
};

/// How surfaces are searched: one by one, or in a median-split tree. Both give the same result.
enum class Search { Brute, Tree };

[[nodiscard]] Masks trace(const Scene& scene, const SceneState& state, const View& view,
                          Search search = Search::Tree);

/// Counts of a mask compared with the oracle's.
struct Agreement {
  std::uint64_t pixel_lights = 0, lit = 0, in_band = 0, wrong_in_band = 0;
  std::uint64_t wrong = 0;                                  ///< outside the band
  std::uint32_t wrong_x = 0, wrong_y = 0, wrong_light = 0;  ///< the last wrong one

  [[nodiscard]] double band_share() const {
    return pixel_lights == 0 ? 0 : static_cast<double>(in_band) / static_cast<double>(pixel_lights);
  }
};

/// Both must have the same size and number of lights.
[[nodiscard]] Agreement compare(const EyeMask& mask, const Masks& truth);

}  // namespace farshade::oracle
