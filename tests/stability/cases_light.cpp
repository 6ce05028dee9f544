/// Extreme lights: near, far, grazing, inside geometry, on edges, many, strong.
#include <cmath>
#include <numbers>

#include "tests/oracle/scene_builder.h"
#include "tests/stability/cases.h"

namespace farshade::stability {
namespace {

/// A corner of the floating box, without rounding.
constexpr glm::dvec3 kCorner{0.3f, 0.6f + 0.2f, 0.3f};

/// The ordinary scene with one point light that gives about 1 lux at a distance of `away_m`.
Setting one_light(const glm::dvec3& position, double candela) {
  Setting setting = unlit();
  setting.scene.point_light(position, candela);
  return setting;
}

/// A light `away_m` above a visible place on the floor.
Setting over_the_floor(double away_m) {
  return one_light({-0.6, away_m, 0.9}, 3 * away_m * away_m);
}

Setting far_light(double away_m) {
  const glm::dvec3 direction = glm::normalize(glm::dvec3(0.4, 1, 0.5));
  return one_light(direction * away_m, 3 * away_m * away_m);
}

/// A sun at this angle from the normal of the floor.
Setting grazing(double from_normal_degrees) {
  const double angle = from_normal_degrees * std::numbers::pi / 180;
  Setting setting = unlit();
  setting.scene.sun({-std::sin(angle), -std::cos(angle), -0.2 * std::sin(angle)}, 1);
  setting.scene.sun({0.3, -1, -0.6}, 0.8);
  return setting;
}

Setting grazing_point(double from_normal_degrees) {
  const double height = 1 / std::tan(from_normal_degrees * std::numbers::pi / 180);
  return one_light({1.0, height, 0.9}, 2);
}

Setting many_lights(int count) {
  Setting setting = unlit();
  for (int i = 0; i < count; ++i) {
    const double angle = 2.4 * i, radius = 0.2 + 1.6 * i / count;
    setting.scene.point_light({radius * std::cos(angle), 1.0 + 0.004 * i, radius * std::sin(angle)},
                              6.0 / count);
  }
  setting.size = {32, 32};
  return setting;
}

Setting at_camera() {
  Setting setting = unlit();
  setting.scene.point_light(setting.head.samples.front().recorded_from_head.translation, 6);
  return setting;
}

/// Looks straight down on the floor from (0.9, 1, 0.9), with both eyes in one place. With an odd number of
/// pixels, the middle pixel shows the point below the head.
Setting looks_down(const glm::dvec3& light, double candela) {
  Setting setting = one_light(light, candela);
  setting.scene.sun({0.3, -1, -0.6}, 0.8);
  setting.head = recorded({.from = {0.9, 1, 0.9},
                           .target = {0.9, 0, 0.9 - 1e-12},
                           .turn_degrees_s = 0,
                           .drift_m_s = glm::dvec3(0)},
                          1);
  setting.head.eye_distance_m = 0;
  setting.set_fov(degrees(-30, 30, 30, -30));
  setting.size = {33, 33};
  return setting;
}

/// A light so strong and near that its irradiance exceeds the range of a float. Half of the floor is in its
/// shadow.
Setting overflowing() {
  Setting setting = unlit();
  setting.scene.point_light({0.45, 0.41, 0.2}, 1e30);
  setting.scene.point_light({-0.6, 1e-7, 0.9}, 1e30);
  setting.scene.sun({0.3, -1, -0.6}, 0.8);
  return setting;
}

/// A scene 4 mm wide, seen from above through a single-sided sheet whose visible side faces down. The light
/// above the floor would give infinite irradiance there, but the sheet shadows the floor from it. Only a
/// second light at the side reaches the floor.
Setting overflowing_in_shadow() {
  Setting setting = unlit({.scale = 1e-3});
  const glm::dvec3 below{9e-4, 0, 9e-4};
  setting.scene.point_light(below + glm::dvec3(0, 5e-5, 0), 1e30);
  setting.scene.point_light(below + glm::dvec3(1e-3, 1.5e-5, 0), 7e-5);
  Mesh sheet = quad({9e-4f, 3e-5f, 9e-4f}, {4e-4f, 0, 0}, {0, 0, 4e-4f});
  sheet.material = setting.scene.material({{"doubleSided", false}});
  setting.scene.add(sheet);
  const glm::dvec3 above = below + glm::dvec3(0, 1e-3, 0);
  setting.head = recorded({.from = above,
                           .target = below - glm::dvec3(0, 0, 1e-15),
                           .turn_degrees_s = 0,
                           .drift_m_s = glm::dvec3(0)},
                          1);
  setting.head.eye_distance_m = 0;
  setting.set_fov(degrees(-30, 30, 30, -30));
  setting.size = {33, 33};
  return setting;
}

Setting narrow_spot() {
  Setting setting = unlit();
  setting.scene.spot_light({0.5, 2, 0.6}, {-0.05, -1, 0.02}, 6, 1e-2);
  setting.scene.sun({0.3, -1, -0.6}, 0.8);
  return setting;
}

Setting wide_spot() {
  Setting setting = unlit();
  setting.scene.spot_light({0.6, 1.4, 0.6}, {-0.05, -1, 0.02}, 4, 1.5707);
  return setting;
}

Setting short_range(double range_m) {
  Setting setting = unlit();
  setting.scene.point_light({0.6, 0.5, 0.6}, 2, range_m);
  setting.scene.sun({0.3, -1, -0.6}, 0.8);
  return setting;
}

std::vector<Case> light_positions() {
  const auto at = [](const char* name, const char* extreme, const glm::dvec3& position, double candela) {
    return Case{.name = name, .extreme = extreme, .make = [=] { return one_light(position, candela); }};
  };
  return {
      {.name = "light-0.1mm",
       .extreme = "light 0.1 mm over the floor",
       .make = [] { return over_the_floor(1e-4); }},
      {.name = "light-1cm",
       .extreme = "light 1 cm over the floor",
       .make = [] { return over_the_floor(1e-2); }},
      {.name = "light-1e4m", .extreme = "light 10 km away", .make = [] { return far_light(1e4); }},
      {.name = "light-1e7m", .extreme = "light 10,000 km away", .make = [] { return far_light(1e7); }},
      {.name = "light-9e8m",
       .extreme = "light near the loader's limit of 1e9 m",
       .make = [] { return far_light(9e8); }},
      at("light-inside-box", "light inside of a closed box", {0, 0.6, 0}, 3),
      at("light-below-floor", "light 0.1 mm under the floor", {-0.6, -1e-4, 0.9}, 3),
      at("light-on-floor", "light in the floor's plane", {-0.6, 0, 0.9}, 3),
      at("light-on-vertex", "light at a corner of the box", kCorner, 3),
      at("light-on-edge", "light on an edge of the box", {kCorner.x, kCorner.y, 0.1}, 3),
      {.name = "light-in-camera", .extreme = "light where the head is", .make = at_camera},
      {.name = "light-on-pixel",
       .extreme = "light at the very point a pixel sees",
       .make =
           [] {
             return looks_down({0.9, 0, 0.9}, 1);
           }},
      {.name = "light-over-pixel",
       .extreme = "light 1 um over the point a pixel sees",
       .make =
           [] {
             return looks_down({0.9, 1e-6, 0.9}, 1e-12);
           }},
      {.name = "light-grazing-89deg", .extreme = "sun at 89 degrees", .make = [] { return grazing(89); }},
      {.name = "light-grazing-89.99deg",
       .extreme = "sun at 89.99 degrees",
       .make = [] { return grazing(89.99); }},
      {.name = "light-point-grazing-89.99deg",
       .extreme = "light at 89.99 degrees 1 m away",
       .make = [] { return grazing_point(89.99); }},
  };
}

std::vector<Case> light_shapes_and_counts() {
  return {
      {.name = "light-overflow", .extreme = "1e30 candela, 0.1 um over the floor", .make = overflowing},
      {.name = "light-overflow-in-shadow",
       .extreme = "1e30 candela, 50 um off, behind a sheet",
       .make = overflowing_in_shadow},
      {.name = "light-spot-0.01rad", .extreme = "a cone of 0.57 degrees", .make = narrow_spot},
      {.name = "light-spot-180deg", .extreme = "a cone of 180 degrees", .make = wide_spot},
      {.name = "light-range-1mm",
       .extreme = "a range that reaches nothing",
       .make = [] { return short_range(1e-3); }},
      {.name = "light-range-0.5m",
       .extreme = "a range that ends on the floor",
       .make = [] { return short_range(0.6); }},
      {.name = "lights-255",
       .extreme = "255 lights",
       .make = [] { return many_lights(255); },
       .like = "lights-256"},
      {.name = "lights-256",
       .extreme = "256 lights",
       .make = [] { return many_lights(256); },
       .like = "lights-256"},
      {.name = "lights-33",
       .extreme = "33 lights: one beyond a word",
       .make = [] { return many_lights(33); },
       .like = "lights-256"},
  };
}

}  // namespace

std::vector<Case> light_cases() {
  return joined({light_positions(), light_shapes_and_counts()});
}

}  // namespace farshade::stability
