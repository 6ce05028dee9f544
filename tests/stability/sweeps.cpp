/// Sweeps: errors as curves. Each point is a case with the same bounds.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "tests/oracle/scene_builder.h"
#include "tests/stability/cases.h"

namespace farshade::stability {
namespace {

using Make = Setting (*)(double);

struct Sweep {
  const char *name, *extreme;
  std::vector<double> points;
  Make make;
  HeadBound head = HeadBound::None;
};

Setting scale(double s) {
  return ordinary({.scale = s});
}

Setting distance_from_origin(double away_m) {
  return ordinary({.origin = glm::dvec3(0.8, 0.1, -0.6) * away_m});
}

Setting turning(double degrees_s, std::uint32_t frames) {
  Setting setting = ordinary();
  setting.frames = frames;
  setting.head = recorded(
      {.turn_degrees_s = degrees_s, .drift_m_s = {0.05, 0, 0}, .faces_at_s = last_shown_s(frames)}, 2);
  return setting;
}

Setting head_speed(double degrees_s) {
  return turning(degrees_s, 30);
}

Setting prediction(double delay_ms) {
  Setting setting = turning(100, 30 + static_cast<std::uint32_t>(delay_ms * 1e-3 * 72));
  setting.delay_ms = delay_ms;
  return setting;
}

/// Near lights are above the floor, far lights beside the scene.
Setting light_distance(double away_m) {
  Setting setting = unlit();
  const glm::dvec3 direction = glm::normalize(glm::dvec3(0.1, 1, 0.15));
  setting.scene.point_light(glm::dvec3(-0.6, 0, 0.9) + direction * away_m, 3 * away_m * away_m);
  return setting;
}

Setting grazing_angle(double from_normal_degrees) {
  const double angle = from_normal_degrees * std::numbers::pi / 180;
  Setting setting = unlit();
  setting.scene.sun({-std::sin(angle), -std::cos(angle), -0.2 * std::sin(angle)}, 1);
  return setting;
}

Setting fov(double full_degrees) {
  Setting setting = ordinary();
  setting.set_fov(degrees(-full_degrees / 2, full_degrees / 2, full_degrees / 2, -full_degrees / 2));
  return setting;
}

/// The nearest object is 100 / ratio metres ahead, but at least 1 mm and at most 0.5 m; the farthest is
/// `ratio` times as far away.
Setting depth_ratio(double ratio) {
  const auto near_m = static_cast<float>(std::max(1e-3, std::min(0.5, 100 / ratio)));
  const float far_m = near_m * static_cast<float>(ratio);
  Setting setting = ordinary();
  setting.scene.add(box({0.5f, 1.6f, 2.5f - near_m}, glm::vec3(0.2f * near_m)));
  setting.scene.add(quad({0, 0, 2.5f - far_m}, {far_m, 0, 0}, {0, far_m, 0}));
  return setting;
}

Setting triangle_aspect(double aspect) {
  std::vector<glm::vec3> corners;
  const float length = 1.6f, width = length / static_cast<float>(aspect);
  for (int i = 0; i < 24; ++i) {
    const float z = -0.6f + 0.05f * static_cast<float>(i), x = -length / 2, y = 0.3f;
    corners.insert(corners.end(), {{x, y, z}, {x + length, y, z}, {x + length, y + width, z}});
  }
  Setting setting = ordinary();
  setting.scene.add(triangle_soup(corners));
  return setting;
}

std::vector<Sweep> sweeps() {
  return {
      {"scale", "scene scale", {1e-3, 1e-2, 0.1, 1, 10, 100, 1e3, 1e4}, scale},
      {"origin", "distance from the origin, m", {0, 1, 10, 100, 1e3, 1e4, 1e5, 1e6}, distance_from_origin},
      {"head-speed",
       "head speed, degrees/s",
       {0, 10, 30, 100, 200, 400, 700, 1000},
       head_speed,
       HeadBound::NoWorseThanHeld},
      {"prediction",
       "prediction, ms",
       {0, 10, 20, 50, 100, 200, 350, 500},
       prediction,
       HeadBound::NoWorseThanHeld},
      {"light-distance", "light distance, m", {1e-4, 1e-3, 1e-2, 0.1, 1, 10, 1e3, 1e5, 1e7}, light_distance},
      {"grazing", "grazing angle, degrees", {80, 85, 88, 89, 89.5, 89.9, 89.95, 89.99}, grazing_angle},
      {"fov", "fov, degrees", {1, 5, 20, 60, 100, 130, 150, 170}, fov},
      {"depth-ratio", "depth ratio", {1e2, 1e3, 1e4, 3e4, 1e5, 3e5, 1e6, 1e7}, depth_ratio},
      {"triangle-aspect", "triangle aspect", {1, 10, 100, 1e3, 1e4, 1e5, 3e5, 1e6}, triangle_aspect},
  };
}

}  // namespace

std::vector<Case> sweep_cases() {
  std::vector<Case> cases;
  for (const Sweep& sweep : sweeps())
    for (const double x : sweep.points)
      cases.push_back({.name = fmt::format("sweep-{}-{:g}", sweep.name, x),
                       .extreme = fmt::format("{} = {:g}", sweep.extreme, x),
                       .sweep = sweep.name,
                       .x = x,
                       .make = [x, make = sweep.make] { return make(x); },
                       .head = sweep.head});
  return cases;
}

}  // namespace farshade::stability
