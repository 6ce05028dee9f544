/// View: where one eye is, what it sees and how many pixels it has. Two of them are a frame's views.
#pragma once

#include <array>
#include <cstddef>

#include "stereo/math/fov.h"
#include "stereo/math/spaces.h"

namespace farshade {

struct View {
  Rigid<Stage, Eye> stage_from_eye;
  EyeFov fov;
  Extent size;
  friend bool operator==(const View&, const View&) = default;
};

inline constexpr std::size_t kEyes = 2;
enum class Side : std::uint8_t { Left = 0, Right = 1 };
inline constexpr std::array<Side, kEyes> kSides{Side::Left, Side::Right};
constexpr std::size_t index_of(Side side) {
  return static_cast<std::size_t>(side);
}
constexpr const char* name_of(Side side) {
  return side == Side::Left ? "left" : "right";
}

/// One value for each eye, left first.
template <class T>
using PerEye = std::array<T, kEyes>;
using StereoView = PerEye<View>;

inline constexpr std::uint32_t kMaxViewSide_px = 8192;

/// Finite pose with unit rotation (within 1e-3), valid fov, sides within 1..kMaxViewSide_px.
[[nodiscard]] bool is_valid(const View& view);

}  // namespace farshade
