/// Settings outside the domain: the programs refuse them with a sentence and never show NaN.
#include <cmath>
#include <limits>

#include "tests/oracle/scene_builder.h"
#include "tests/stability/cases.h"

namespace farshade::stability {
namespace {

Setting with_fov(double half_degrees) {
  Setting setting = ordinary();
  setting.set_fov(degrees(-half_degrees, half_degrees, 40, -40));
  return setting;
}

Setting every_row(const std::function<void(HeadSample&)>& change) {
  Setting setting = ordinary();
  std::ranges::for_each(setting.head.samples, change);
  return setting;
}

Setting far_origin() {
  return ordinary({.origin = {2e9, 0, 0}});
}

Setting unrepresentable_light() {
  Setting setting = unlit();
  setting.scene.point_light({0, 2e9, 0}, 1);
  return setting;
}

Setting lights(int count) {
  Setting setting = unlit();
  for (int i = 0; i < count; ++i) setting.scene.point_light({0, 2, 0.01 * i}, 1);
  return setting;
}

Setting nan_vertex() {
  Setting setting = ordinary();
  Mesh mesh = quad({0, 1, 0}, {1, 0, 0}, {0, 1, 0});
  mesh.positions[1].y = std::numeric_limits<float>::quiet_NaN();
  setting.scene.add(mesh);
  return setting;
}

Setting flat_scale() {
  Setting setting = ordinary();
  setting.scene.add(box({0, 0, 0}, glm::vec3(0.1f)), at({0, 1, 0}, {1, 0, 1}));
  return setting;
}

Setting singular_matrix() {
  Setting setting = ordinary();
  setting.scene.add(box({0, 0, 0}, glm::vec3(0.1f)),
                    by_matrix(glm::dmat3({1, 0, 0}, {1, 0, 0}, {0, 0, 1}), {0, 1, 0}));
  return setting;
}

Setting overflowing_scale() {
  Setting setting = ordinary();
  setting.scene.add(box({0, 0, 0}, glm::vec3(1e30f)), at({0, 1, 0}, glm::dvec3(1e20)));
  return setting;
}

Setting with_option(std::vector<std::string> options) {
  Setting setting = ordinary();
  setting.options = std::move(options);
  return setting;
}

Setting descending() {
  Setting setting = ordinary();
  std::ranges::reverse(setting.head.samples);
  return setting;
}

}  // namespace

std::vector<Case> refused_cases() {
  const auto client = [](const char* name, const char* extreme, std::function<Setting()> make) {
    return Case{.name = name, .extreme = extreme, .make = std::move(make), .outcome = Outcome::Refused};
  };
  const auto both = [](const char* name, const char* extreme, std::function<Setting()> make) {
    return Case{.name = name, .extreme = extreme, .make = std::move(make), .outcome = Outcome::BothRefuse};
  };
  return {
      client("refused-fov-180", "a fov of 180 degrees", [] { return with_fov(90); }),
      client("refused-fov-empty", "a fov of 0 degrees", [] { return with_fov(0); }),
      client("refused-head-off-unit", "quaternions of length 1.1",
             [] { return every_row([](HeadSample& s) { s.recorded_from_head.rotation *= 1.1; }); }),
      client("refused-head-nan", "heads at NaN",
             [] { return every_row([](HeadSample& s) { s.recorded_from_head.translation.x = NAN; }); }),
      client("refused-head-2e9m", "heads 2e9 m out",
             [] { return every_row([](HeadSample& s) { s.recorded_from_head.translation.x = 2e9; }); }),
      client("refused-trace-descending", "stamps that run backward all the way", descending),
      client("refused-delay", "masks 501 ms late",
             [] {
               return with_option({"--delay", "501"});
             }),
      client("refused-size-0", "no pixels",
             [] {
               return with_option({"--size", "0x5"});
             }),
      client("refused-size-8193", "a side beyond the longest",
             [] {
               return with_option({"--size", "8193x4"});
             }),
      both("refused-origin-2e9m", "a scene 2e9 m out", far_origin),
      both("refused-light-2e9m", "a light 2e9 m out", unrepresentable_light),
      both("refused-lights-257", "257 lights", [] { return lights(257); }),
      both("refused-vertex-nan", "a vertex at NaN", nan_vertex),
      both("refused-scale-0", "an instance scaled to nothing", flat_scale),
      both("refused-singular", "a matrix that cannot be inverted", singular_matrix),
      both("refused-overflow", "vertices at 1e50 m", overflowing_scale),
  };
}

}  // namespace farshade::stability
