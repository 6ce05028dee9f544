/// Composition: which pictures stand where in the window. Pure: pixels in, rectangles out.
#pragma once

#include <vector>

#include "stereo/frame/view.h"

namespace farshade {

enum class StereoLayout : std::uint8_t {
  SideBySide,  ///< the first picture on the left
  CrossEyed,   ///< the first picture on the right: who squints sees depth
  Mono,        ///< the first picture alone
  Anaglyph,    ///< both in one, for glasses that are red on the left and cyan on the right
};

/// Eyes as the renderer drew them, or pictures that were uploaded in their place.
enum class Picture : std::uint8_t { LeftEye, RightEye, LeftUpload, RightUpload };

/// A run of columns of each picture, of one width, as which both eyes look into one another's directions.
struct SharedColumns {
  PerEye<std::uint32_t> first{};
  std::uint32_t count = 0;  ///< 0: all of both pictures
  friend bool operator==(const SharedColumns&, const SharedColumns&) = default;
};

/// Where a point so far ahead of the head lies on the screen of an anaglyph itself, not before or behind it.
inline constexpr double kScreen_m = 2;

/// The columns that eyes of `eye` pixels share in an anaglyph: eyes whose fov is not symmetric, as those of
/// headsets are, see the same thing in different columns. All where they share nothing.
[[nodiscard]] SharedColumns shared_columns(const PerEye<EyeFov>& fov, double eye_distance_m, Extent eye);

struct Composition {
  StereoLayout layout = StereoLayout::SideBySide;
  PerEye<Picture> pictures{Picture::LeftEye, Picture::RightEye};
  double aspect =
      1;  ///< width / height of an eye's window on the plane z = -1; its pixels need not be square
  SharedColumns shared{};      ///< Anaglyph shows these alone
  std::uint32_t right_px = 0;  ///< of the window's right side, left free
};

/// One picture's place in the window, pixels.
struct Panel {
  std::uint32_t left = 0, top = 0;
  Extent size;
  std::size_t eye = 0;  ///< which of the composition's pictures
  friend bool operator==(const Panel&, const Panel&) = default;
};

/// At least 1 and below this, the scale that would fill the window is taken as 1: a picture that is shown
/// pixel by pixel is sharper than one that is hardly larger.
inline constexpr double kFillScale = 1.25;

/// Places for pictures of `eye` pixels, all of one size, as large as fits with the aspect kept, each in the
/// middle of its half (Mono, Anaglyph: of the window). None where not one pixel fits.
[[nodiscard]] std::vector<Panel> panel_rects(Extent window, Extent eye, double aspect, StereoLayout layout);

/// What of `window` is left for panels.
[[nodiscard]] constexpr Extent left_of(Extent window, std::uint32_t right_px) {
  return {window.width > right_px ? window.width - right_px : 0, window.height};
}

}  // namespace farshade
