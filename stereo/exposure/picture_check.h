/// PictureCheck: what is wrong with the light of the finished picture, in sentences for whoever starts a
/// program. A sentence names a cure only after it was tried on the same points.
///
/// The points are what rays through the pictures meet at time 0. Their colours are means over whole meshes.
#pragma once

#include <string>
#include <vector>

#include "stereo/frame/exposure.h"
#include "stereo/placement/surroundings.h"
#include "stereo/scene/lighting.h"

namespace farshade {

struct PictureFinding {
  bool is_bad = false;  ///< the picture is of no use as it is
  std::string sentence;
};

/// Tells if everything that is seen is (almost) black; if over half of it is as bright as can be (any colour
/// channel); and which lights reach nothing of it, also whether one thing that is closed around the scene
/// blocks them (sky.h has the rule for what is no obstacle). Empty if all is well, or less than 16 rays meet
/// a surface.
///
/// `rays` go through the pictures. `lighting` is what the user gave, and already part of `scene`; `exposure`
/// is the one in use.
[[nodiscard]] std::vector<PictureFinding> check_picture(const Surroundings& surroundings, const Scene& scene,
                                                        const Lighting& lighting, const Exposure& exposure,
                                                        std::span<const Ray> rays);

}  // namespace farshade
