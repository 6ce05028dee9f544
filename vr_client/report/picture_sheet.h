/// Picture sheet: pictures of one size in rows, each under a line that says what it shows.
#pragma once

#include <string>
#include <vector>

#include "stereo/image/image.h"

namespace farshade {

struct LabelledPicture {
  std::string label;  ///< ASCII; cut off at the picture's width
  Image<Rgb8> picture;
};

/// All pictures have one size, and all rows one length. At least one picture.
[[nodiscard]] Image<Rgb8> picture_sheet(const std::vector<std::vector<LabelledPicture>>& rows);

}  // namespace farshade
