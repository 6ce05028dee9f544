/// Composition: computes where in the window each picture is shown.
#pragma once

#include <optional>
#include <vector>

#include "stereo/frame/view.h"

namespace farshade {

enum class StereoLayout : std::uint8_t {
  SideBySide,  ///< the first picture on the left
  CrossEyed,   ///< the first picture on the right, for viewing with crossed eyes
  Mono,        ///< only the first picture
  Anaglyph,    ///< both pictures in one, for red-cyan glasses
};

/// The picture of an eye as drawn, or an uploaded picture that replaces it.
enum class Picture : std::uint8_t { LeftEye, RightEye, LeftUpload, RightUpload };

/// The columns that show the same directions in both eyes.
struct SharedColumns {
  PerEye<std::uint32_t> first{};
  std::uint32_t count = 0;  ///< 0: all columns of both pictures
  friend bool operator==(const SharedColumns&, const SharedColumns&) = default;
};

/// In an anaglyph, points at this distance ahead of the head appear in the plane of the screen.
inline constexpr double kScreen_m = 2;

/// The shared columns of two eyes of `eye` pixels each, for an anaglyph. The fov of a headset's eyes is not
/// symmetric, so that the same direction lies in different columns. Returns all columns if the eyes share
/// none.
[[nodiscard]] SharedColumns shared_columns(const PerEye<EyeFov>& fov, double eye_distance_m, Extent eye);

struct Composition {
  StereoLayout layout = StereoLayout::SideBySide;
  PerEye<Picture> pictures{Picture::LeftEye, Picture::RightEye};
  double aspect = 1;       ///< width / height of an eye's view on the plane z = -1; pixels may be non-square
  SharedColumns shared{};  ///< the columns that Anaglyph shows
  std::uint32_t right_px = 0;  ///< width of the right part of the window that stays free for the panel
};

/// The rectangle of one picture in the window, pixels.
struct Panel {
  std::uint32_t left = 0, top = 0;
  Extent size;
  std::size_t eye = 0;  ///< index into Composition::pictures
  friend bool operator==(const Panel&, const Panel&) = default;
};

/// If the largest scale that fits is at least 1 and below this value, pictures are shown at scale 1: an
/// unscaled picture is sharper than one that is slightly larger.
inline constexpr double kFillScale = 1.25;

/// The rectangles of pictures of `eye` pixels. They have one size, the largest that fits with this aspect
/// ratio, and are centred in the halves of the window (Mono and Anaglyph: in the window). Empty if no pixel
/// fits.
[[nodiscard]] std::vector<Panel> panel_rects(Extent window, Extent eye, double aspect, StereoLayout layout);

/// The part of each eye that `composition` shows, and its aspect ratio.
struct ShownPart {
  Extent size;
  double aspect = 1;
};
[[nodiscard]] ShownPart shown_part(const Composition& composition, Extent eye);

/// A pixel of an eye in the window.
struct PixelOfEye {
  std::size_t eye = 0;  ///< index into Composition::pictures
  glm::uvec2 pixel{0};
  friend bool operator==(const PixelOfEye&, const PixelOfEye&) = default;
};

/// The pixel that `composition` shows at a place of the window, in pixels from its top left corner; in an
/// anaglyph, that of the first picture. Empty beside the pictures.
[[nodiscard]] std::optional<PixelOfEye> pixel_at(const Composition& composition, Extent window, Extent eye,
                                                 glm::dvec2 place);

/// The part of `window` beside the panel.
[[nodiscard]] constexpr Extent left_of(Extent window, std::uint32_t right_px) {
  return {window.width > right_px ? window.width - right_px : 0, window.height};
}

}  // namespace farshade
