/// A head that walks and looks around, as text in any axes, for tests of readers.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "stereo/head/axes.h"
#include "stereo/math/rotation.h"

namespace farshade {

inline constexpr int kWornSamples = 144;
inline constexpr double kWornRate_hz = 72;

/// In stage axes: 1.6 m high, walks ahead at 1 m/s, turns by up to 40 degrees and nods by up to 15.
inline Rigid<Recorded, Head> worn_head(int sample) {
  const double s = sample / kWornRate_hz;
  const glm::dquat yaw = rotation_exp({0, 0.7 * std::sin(2 * s), 0}),
                   pitch = rotation_exp({0.26 * std::sin(5 * s), 0, 0});
  return {yaw * pitch, {0.1 * std::sin(s), 1.6, -s}};
}

/// The numbers of the same pose with other axes.
inline Rigid<Recorded, Head> with_axes(const Rigid<Recorded, Head>& pose, const Axes& axes) {
  const glm::dmat3 rotation =
      glm::transpose(axes.stage_from_world) * glm::mat3_cast(pose.rotation) * axes.head_from_body;
  return {glm::quat_cast(rotation),
          glm::transpose(axes.stage_from_world) * pose.translation * axes.units_a_metre};
}

/// Rows `stamp,x,y,z,` and a quaternion. `first` and `step` are stamps in their unit; stamps are whole if
/// `step` is.
struct Text {
  double first = 1.7e9, step = 1 / kWornRate_hz;
  char separator = ',';
  bool scalar_first = true;
  Axes axes{};
  std::string more{};  ///< further columns of each row
};

inline std::string text_of(const Text& text) {
  std::string rows;
  const char c = text.separator;
  for (int i = 0; i < kWornSamples; ++i) {
    const auto [q, p] = with_axes(worn_head(i), text.axes);
    const double stamp = text.first + i * text.step;
    rows += text.step == std::floor(text.step) ? fmt::format("{:.0f}", stamp) : fmt::format("{:.6f}", stamp);
    rows += fmt::format("{}{:.6f}{}{:.6f}{}{:.6f}{}", c, p.x, c, p.y, c, p.z, c);
    rows += text.scalar_first ? fmt::format("{:.7f}{}{:.7f}{}{:.7f}{}{:.7f}", q.w, c, q.x, c, q.y, c, q.z)
                              : fmt::format("{:.7f}{}{:.7f}{}{:.7f}{}{:.7f}", q.x, c, q.y, c, q.z, c, q.w);
    rows += text.more + '\n';
  }
  return rows;
}

}  // namespace farshade
