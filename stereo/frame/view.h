/// View: pose, field of view and size in pixels of one eye. A frame has two views.
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

/// One value per eye, left first.
template <class T>
using PerEye = std::array<T, kEyes>;
using StereoView = PerEye<View>;

inline constexpr std::uint32_t kMaxViewSide_px = 8192;

/// True for a finite pose with unit rotation (within 1e-3), a valid fov, and sides from 1 to kMaxViewSide_px.
[[nodiscard]] bool is_valid(const View& view);

}  // namespace farshade
