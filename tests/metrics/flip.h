/// FLIP: how large a viewer who flips between two pictures finds the difference at each pixel. Andersson,
/// Nilsson, Akenine-Moeller, Oskarsson, Astrom and Fairchild, "FLIP: A Difference Evaluator for Alternating
/// Images", HPG 2020, for 8-bit sRGB pictures, with the paper's constants.
///
/// Both pictures are first seen alone: blurred as far as the eye blurs each opponent channel, brought to a
/// colour space in which distances are differences seen, and searched for edges and points. Then, pixel by
/// pixel, error = colour difference ^ (1 - feature difference), from 0 (equal) to 1.
#pragma once

#include "stereo/image/image.h"

namespace farshade {

/// One picture as the viewer sees it. Comparing several pictures with one reference sees the reference once.
struct SeenPicture {
  double pixels_per_degree = 0;
  Image<glm::vec3> colour;  ///< filtered L*a*b* (D65) after the Hunt adjustment; L* is 0 to 100
  Image<float> edges;       ///< gradient magnitude of relative luminance; a step from 0 to 1 has at most 1
  Image<float> points;      ///< magnitude of second derivatives likewise; a lone pixel has at most sqrt 2
};

/// `pixels_per_degree`: pixels in one degree of the visual field, of the display and at the centre of the
/// view, from 1e-6 to 1e5 (anything else is a bug of the caller). The filters reach about 0.135 degrees;
/// where they leave the picture its border pixels repeat. Time and filter width are proportional to it.
[[nodiscard]] SeenPicture see(const Image<Rgb8>& picture, double pixels_per_degree);

/// The error a pixel, 0 to 1; 0 wherever the seen colours are equal. Both have one size and one number of
/// pixels a degree.
[[nodiscard]] Image<float> flip(const SeenPicture& reference, const SeenPicture& test);
[[nodiscard]] Image<float> flip(const Image<Rgb8>& reference, const Image<Rgb8>& test,
                                double pixels_per_degree);

/// Mean over pixels, the one figure reported for a picture; 0 of an empty one.
[[nodiscard]] double mean(const Image<float>& error);

}  // namespace farshade
