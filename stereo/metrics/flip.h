/// FLIP: the size of the difference, at each pixel, that a viewer sees who flips between two pictures.
/// Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astrom and Fairchild, "FLIP: A Difference Evaluator for
/// Alternating Images", HPG 2020, for 8-bit sRGB pictures, with the paper's constants.
///
/// Each picture is first processed alone. Its opponent channels are blurred as the eye blurs them, it is
/// converted to a colour space in which distances are perceived differences, and its edges and points are
/// detected. Then for each pixel, error = colour difference ^ (1 - feature difference), from 0 (equal) to 1.
#pragma once

#include "stereo/image/image.h"

namespace farshade {

/// One picture as the viewer sees it. It can be compared with several pictures.
struct SeenPicture {
  double pixels_per_degree = 0;
  Image<glm::vec3> colour;  ///< filtered L*a*b* (D65) after the Hunt adjustment; L* is 0 to 100
  Image<float> edges;       ///< gradient magnitude of relative luminance; at most 1 for a step from 0 to 1
  Image<float> points;      ///< magnitude of the second derivatives; at most sqrt 2 for a single pixel
};

/// `pixels_per_degree` is the number of pixels in one degree of the visual field at the centre of the view,
/// from 1e-6 to 1e5 (checked). The filters reach about 0.135 degrees. Beyond the border the picture repeats
/// its border pixels. The run time and the filter width are proportional to pixels_per_degree.
[[nodiscard]] SeenPicture see(const Image<Rgb8>& picture, double pixels_per_degree);

/// The error of each pixel, 0 to 1; 0 where the perceived colours are equal. Both pictures have the same size
/// and the same pixels_per_degree.
[[nodiscard]] Image<float> flip(const SeenPicture& reference, const SeenPicture& test);
[[nodiscard]] Image<float> flip(const Image<Rgb8>& reference, const Image<Rgb8>& test,
                                double pixels_per_degree);

/// The mean over all pixels, which is the reported figure; 0 for an empty picture.
[[nodiscard]] double mean(const Image<float>& error);

}  // namespace farshade
