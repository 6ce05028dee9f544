#include "stereo/frame/view.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

namespace farshade {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

View good_view() {
  return {{glm::dquat(1, 0, 0, 0), {1, 1.6, -2}}, {-0.9, 0.8, 0.7, -0.6}, {512, 512}};
}

TEST(ViewIsValid, AcceptsWholeDomain) {
  View view = good_view();
  EXPECT_TRUE(is_valid(view));
  view.stage_from_eye.rotation = glm::dquat(1.0009, 0, 0, 0);
  view.stage_from_eye.translation = {1e6, -1e6, 1e6};
  view.size = {kMaxViewSide_px, 1};
  EXPECT_TRUE(is_valid(view));
}

TEST(ViewIsValid, RefusesEachFault) {
  struct Row {
    const char* name;
    std::function<void(View&)> harm;
  };
  const std::vector<Row> rows{
      {"rotation too short", [](View& v) { v.stage_from_eye.rotation.w = 0.9989; }},
      {"rotation too long", [](View& v) { v.stage_from_eye.rotation.w = 1.0011; }},
      {"rotation zero", [](View& v) { v.stage_from_eye.rotation = glm::dquat(0, 0, 0, 0); }},
      {"rotation NaN", [](View& v) { v.stage_from_eye.rotation.x = kNan; }},
      {"position NaN", [](View& v) { v.stage_from_eye.translation.y = kNan; }},
      {"position infinite", [](View& v) { v.stage_from_eye.translation.z = -kInfinity; }},
      {"fov turned over", [](View& v) { std::swap(v.fov.left_rad, v.fov.right_rad); }},
      {"fov NaN", [](View& v) { v.fov.up_rad = kNan; }},
      {"no width", [](View& v) { v.size.width = 0; }},
      {"no height", [](View& v) { v.size.height = 0; }},
      {"too wide", [](View& v) { v.size.width = kMaxViewSide_px + 1; }},
      {"too high", [](View& v) { v.size.height = 100'000; }},
  };
  for (const Row& row : rows) {
    View view = good_view();
    row.harm(view);
    EXPECT_FALSE(is_valid(view)) << row.name;
  }
}

TEST(Side, IndexesLeftFirst) {
  EXPECT_EQ(index_of(Side::Left), 0u);
  EXPECT_EQ(index_of(Side::Right), 1u);
  EXPECT_STREQ(name_of(kSides[0]), "left");
  EXPECT_STREQ(name_of(kSides[1]), "right");
}

}  // namespace
}  // namespace farshade
