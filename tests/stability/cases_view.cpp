/// Extreme views: fov, sizes, eye distances, eye positions.
#include "tests/oracle/scene_builder.h"
#include "tests/stability/cases.h"

namespace farshade::stability {
namespace {

Setting with_fov(double left, double right, double up, double down) {
  Setting setting = ordinary();
  setting.set_fov(degrees(left, right, up, down));
  return setting;
}

Setting symmetric(double full_degrees) {
  return with_fov(-full_degrees / 2, full_degrees / 2, full_degrees / 2, -full_degrees / 2);
}

Setting with_size(Extent size) {
  Setting setting = ordinary();
  setting.size = size;
  return setting;
}

/// A fov so narrow that no edge crosses any pixel.
Setting one_pixel() {
  Setting setting = symmetric(1);
  setting.size = {1, 1};
  return setting;
}

Setting with_eyes(double distance_m) {
  Setting setting = ordinary();
  setting.head.eye_distance_m = distance_m;
  return setting;
}

Setting from(const glm::dvec3& place, const glm::dvec3& target) {
  Setting setting = ordinary();
  setting.head = recorded({.from = place, .target = target, .drift_m_s = {0.02, 0.01, -0.01}}, 1);
  return setting;
}

/// A wall around the head, closer than the near plane.
Setting in_a_box(double half_m) {
  Setting setting = ordinary();
  setting.scene.add(box({0, 0, 0}, glm::vec3(1)), at({0.5, 1.6, 2.5}, glm::dvec3(half_m)));
  setting.scene.point_light({0.5 + 0.3 * half_m, 1.6 + 0.2 * half_m, 2.5}, 3 * half_m * half_m);
  setting.head = recorded({.turn_degrees_s = 20, .drift_m_s = glm::dvec3(0)}, 1);
  setting.head.eye_distance_m = std::min(0.063, 0.5 * half_m);
  return setting;
}

Setting different_eyes() {
  Setting setting = ordinary();
  setting.head.fov = {degrees(-50, 5, 20, -40), degrees(-3, 60, 35, -10)};
  return setting;
}

std::vector<Case> fields_of_view_and_sizes() {
  const auto sized = [](const char* name, const char* extreme, Extent size, const char* like) {
    return Case{.name = name, .extreme = extreme, .make = [=] { return with_size(size); }, .like = like};
  };
  return {
      {.name = "fov-1", .extreme = "a fov of 1 degree", .make = [] { return symmetric(1); }},
      {.name = "fov-0.1", .extreme = "a fov of 0.1 degrees", .make = [] { return symmetric(0.1); }},
      {.name = "fov-150", .extreme = "a fov of 150 degrees", .make = [] { return symmetric(150); }},
      {.name = "fov-170", .extreme = "a fov of 170 degrees", .make = [] { return symmetric(170); }},
      {.name = "fov-179",
       .extreme = "a fov of 179 degrees, the most there is",
       .make = [] { return symmetric(179); }},
      {.name = "fov-asymmetric",
       .extreme = "-80 to 10 degrees by 5 to -70",
       .make = [] { return with_fov(-80, 10, 5, -70); }},
      {.name = "fov-off-axis",
       .extreme = "10 to 60 degrees: ahead is not in view",
       .make = [] { return with_fov(10, 60, -5, -50); }},
      {.name = "fov-170-by-1",
       .extreme = "170 degrees wide, 1 high",
       .make = [] { return with_fov(-85, 85, -20, -21); }},
      {.name = "fov-of-each-eye", .extreme = "two eyes that share little", .make = different_eyes},
      sized("size-372x372", "nothing: more pixels", {372, 372}, "size-372x372"),
      {.name = "size-1x1", .extreme = "one pixel an eye", .make = one_pixel},
      sized("size-1x97", "one column", {1, 97}, "ordinary"),
      sized("size-97x1", "one row", {97, 1}, "ordinary"),
      sized("size-prime", "83 x 61 pixels", {83, 61}, "ordinary"),
      sized("size-2000x3", "2,000 x 3 pixels", {2000, 3}, "ordinary"),
      sized("size-8192x1", "the longest side there is", {8192, 1},
            "size-372x372"),  // 17 rows with its guard band,
  };
}

std::vector<Case> eyes_and_cameras() {
  return {
      {.name = "eyes-0", .extreme = "both eyes in one place", .make = [] { return with_eyes(0); }},
      {.name = "eyes-1um", .extreme = "eyes 1 um apart", .make = [] { return with_eyes(1e-6); }},
      {.name = "eyes-1m",
       .extreme = "eyes 1 m apart, the most there is",
       .make = [] { return with_eyes(1); }},
      {.name = "camera-on-floor",
       .extreme = "a head 1 mm over the floor",
       .make =
           [] {
             return from({0.9, 1e-3, 1.2}, {0, 1e-3, 0});
           }},
      {.name = "camera-in-floor",
       .extreme = "a head in the floor's plane",
       .make =
           [] {
             return from({0.9, 0, 1.2}, {0, 0.2, 0});
           }},
      {.name = "camera-in-wall",
       .extreme = "a head inside of the box",
       .make =
           [] {
             return from({0.05, 0.6, 0.02}, {-0.5, 0.2, -1});
           }},
      {.name = "camera-looks-down",
       .extreme = "a head that looks straight down",
       .make =
           [] {
             return from({0.6, 1.5, 0.6}, {0.6, 0, 0.6 - 1e-9});
           }},
      {.name = "camera-in-1mm-box",
       .extreme = "walls 1 mm around the eyes",
       .make = [] { return in_a_box(1e-3); }},
      {.name = "camera-in-10cm-box",
       .extreme = "walls 10 cm around the eyes",
       .make = [] { return in_a_box(0.1); }},
      {.name = "camera-sees-nothing",
       .extreme = "nothing in view",
       .make =
           [] {
             return from({0.5, 1.6, 2.5}, {0.5, 30, 40});
           }},
  };
}

}  // namespace

std::vector<Case> view_cases() {
  return joined({fields_of_view_and_sizes(), eyes_and_cameras()});
}

}  // namespace farshade::stability
