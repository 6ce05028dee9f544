#include "stereo/frame/cube_mask.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "stereo/frame/tiles.h"

namespace farshade {

Extent face_size(Extent size) {
  constexpr double kPart = 2;  // all faces together, of the pixels of both shown views: docs/cube-mask.md
  const double side =
      std::sqrt(kPart * kEyes * static_cast<double>(size.pixels()) / (kEyes * kCubeMaskPairs));
  const std::uint32_t tiles = static_cast<std::uint32_t>(side) / kTileSide_px;
  const std::uint32_t px = std::clamp(tiles * kTileSide_px, kLeastFace_px, kMostFace_px);
  return {px, px};
}

StereoView faces_about(Point<Stage> centre, std::size_t pair, Extent face) {
  using std::numbers::pi;
  // An eye looks along its -z axis. Each rotation turns that axis in a face's direction.
  const auto about = [](double angle, const glm::dvec3& axis) { return glm::angleAxis(angle, axis); };
  const glm::dvec3 x{1, 0, 0}, y{0, 1, 0};
  const std::array<PerEye<glm::dquat>, kCubeMaskPairs> rotations{{{about(-pi / 2, y), about(pi / 2, y)},
                                                                  {about(pi / 2, x), about(-pi / 2, x)},
                                                                  {about(pi, y), glm::dquat(1, 0, 0, 0)}}};
  const double half = std::atan(face.width / (face.width - 2.0));
  StereoView faces;
  for (std::size_t i = 0; i < kEyes; ++i)
    faces[i] = {{rotations[pair][i], centre.v}, {-half, half, half, -half}, face};
  return faces;
}

}  // namespace farshade
