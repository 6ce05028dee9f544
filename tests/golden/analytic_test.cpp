/// Box over plane (assets/ORIGIN.md): each pixel of the plane has the colour that was computed on paper.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "stereo/scene/scene_state.h"
#include "tests/golden/test_rig.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

constexpr double kMargin_m = 2e-3;  ///< pixels nearer than this to an outline are left out

struct Rectangle {
  double x0, x1, z0, z1;
  /// Distance to the outline in metres; positive inside, negative outside.
  [[nodiscard]] double inside(const glm::dvec3& p) const {
    return std::min({p.x - x0, x1 - p.x, p.z - z0, z1 - p.z});
  }
};

/// The shadows of the point light and of the directional light.
constexpr std::array<Rectangle, 2> kShadows{Rectangle{-0.95, 0.65, -0.8, 0.8},
                                            Rectangle{0.5, 2.0, -0.5, 0.5}};

/// Whether the ray meets the box, enlarged by `grown`, before `end`.
bool meets_box(const glm::dvec3& origin, const glm::dvec3& direction, double end, double grown) {
  const glm::dvec3 low = glm::dvec3(-0.5, 1, -0.5) - grown, high = glm::dvec3(0.5, 1.5, 0.5) + grown;
  double enter = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (low[axis] - origin[axis]) / direction[axis],
                 b = (high[axis] - origin[axis]) / direction[axis];
    enter = std::max(enter, std::min(a, b));
    end = std::min(end, std::max(a, b));
  }
  return enter < end;
}

/// The point of the plane that pixel (x, y) shows. Empty if the pixel shows something else or is near an
/// outline.
std::optional<glm::dvec3> plane_point(const View& view, std::uint32_t x, std::uint32_t y) {
  const glm::dvec3 ray =
      view.stage_from_eye.rotation * pixel_ray(tangents_of(view.fov), view.size, {x + 0.5, y + 0.5});
  const glm::dvec3 eye = view.stage_from_eye.translation;
  const double t = -eye.y / ray.y;
  if (ray.y >= 0 || meets_box(eye, ray, t, kMargin_m)) return std::nullopt;
  const glm::dvec3 p = eye + ray * t;
  if (std::max(std::abs(p.x), std::abs(p.z)) > 4 - kMargin_m) return std::nullopt;
  return p;
}

int srgb8(double linear) {
  const double coded = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
  return static_cast<int>(std::lround(255 * coded));
}

/// I = (I_d / pi) (k_0 cos_0 30 cd / d^2 + k_1 cos_1 1.2 lx) on the plane, whose base colour is 0.7 grey.
int paper_grey(const glm::dvec3& p, std::array<bool, 2> lit) {
  const glm::dvec3 to_point = glm::dvec3(0.25, 4, 0) - p;
  const double d = glm::length(to_point);
  const double from_point = to_point.y / d * 30 / (d * d), from_sun = 1.2 / std::numbers::sqrt2;
  return srgb8(0.7 / std::numbers::pi * ((lit[0] ? from_point : 0) + (lit[1] ? from_sun : 0)));
}

/// The number of the plane's pixels for each set of lights that they see, and the number with a wrong colour.
struct Verdict {
  std::array<std::size_t, 4> checked{};
  std::size_t unlike = 0;
  int farthest = 0;
};

/// Leaves out pixels nearer than `margin_m` to a shadow's outline, and pixels without a known mask.
Verdict check_plane(const Shown& shown, const StereoView& views, double margin_m) {
  Verdict verdict;
  for (const Side side : kSides) {
    const Image<Rgb8>& picture = shown.pictures[index_of(side)];
    for (std::uint32_t y = 0; y < picture.size.height; ++y)
      for (std::uint32_t x = 0; x < picture.size.width; ++x) {
        const auto p = plane_point(views[index_of(side)], x, y);
        if (!p || shown.reports[index_of(side)].sources[y * picture.size.width + x] == kSourceUnknown)
          continue;
        const std::array inside{kShadows[0].inside(*p), kShadows[1].inside(*p)};
        if (std::min(std::abs(inside[0]), std::abs(inside[1])) < margin_m) continue;
        const std::array lit{inside[0] < 0, inside[1] < 0};
        const glm::ivec3 apart = glm::abs(glm::ivec3(picture.at(x, y)) - paper_grey(*p, lit));
        ++verdict.checked[static_cast<std::size_t>(lit[0] + 2 * lit[1])];
        verdict.unlike += std::max({apart.x, apart.y, apart.z}) > 1 ? 1 : 0;
        verdict.farthest = std::max({verdict.farthest, apart.x, apart.y, apart.z});
      }
  }
  return verdict;
}

void expect_as_on_paper(const Verdict& verdict) {
  EXPECT_EQ(verdict.unlike, 0u) << "of " << verdict.checked[3] << " lit pixels and more; the farthest is "
                                << verdict.farthest << " of 255 away";
  EXPECT_GT(verdict.checked[0], 50u) << "in both shadows";
  EXPECT_GT(verdict.checked[1], 500u) << "in the directional light's shadow";
  EXPECT_GT(verdict.checked[2], 500u) << "in the point light's shadow";
  EXPECT_GT(verdict.checked[3], 5000u) << "in no shadow";
}

class PaperPicture : public OnLavapipe {
 protected:
  TestRig rig_{device_, bundled("box_over_plane.gltf"), 256};
  StereoView now_ = rig_.eyes(rig_.head());
};

TEST_F(PaperPicture, HasEveryColourOfThePlaneRight) {
  const Mask own = rig_.ask(kNow, now_);
  expect_as_on_paper(check_plane(rig_.show(now_, {own.traced_mask()}, kPlainReprojection), now_, kMargin_m));
}

TEST_F(PaperPicture, KeepsShadowsInPlaceUnderStaleMasks) {
  const Mask stale =
      rig_.ask(kTraced, rig_.eyes(moved(rig_.head(), 3 * std::numbers::pi / 180, {0.02, 0, 0})));
  constexpr double kPixel_m = 0.04;  ///< the footprint of a pixel on the plane near the box
  expect_as_on_paper(check_plane(rig_.show(now_, {stale.traced_mask()}), now_, kPixel_m));
}

TEST_F(PaperPicture, IsNotOnPaperWhenThePoseDeltaIsIgnored) {
  const Mask stale =
      rig_.ask(kTraced, rig_.eyes(moved(rig_.head(), 3 * std::numbers::pi / 180, {0.02, 0, 0})));
  const Shown ignored = rig_.show(now_, {stale.traced_mask()}, {.lookup = Lookup::Direct});
  EXPECT_GT(check_plane(ignored, now_, 0.04).unlike, 500u);
}

class Formula : public OnLavapipe {};

/// A spot with a range and a soft cone above a white floor. No mask exists, so every pixel is lit.
TEST_F(Formula, RangeAndConeFallOffAsTheExtensionSays) {
  const glm::dvec3 at(0.3, 2, -0.2);
  const double range_m = 3, outer_rad = 0.9;
  SceneBuilder builder;
  builder.add(quad({0, 0, 0}, {0, 0, 4}, {4, 0, 0}));
  builder.spot_light(at, {0, -1, 0}, static_cast<float>(outer_rad));
  Scene scene = builder.build();
  scene.lights[0].range_m = static_cast<float>(range_m);
  scene.lights[0].intensity = glm::vec3(30);
  const Light light = state_at(scene, Time{}).light_set.lights[0];
  TestRig rig(device_, std::move(scene), 192);
  const StereoView views = rig.eyes(head_looking({0.4, 1.8, 3}, {0, 0, 0}));
  const Shown shown = rig.show(views, {});
  const double inner = std::cos(double{light.inner_cone_rad}), outer = std::cos(double{light.outer_cone_rad});
  std::size_t checked = 0, wrong = 0, dark = 0;
  for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t) {
    const View& view = views[index_of(side)];
    const glm::dvec3 ray =
        view.stage_from_eye.rotation * pixel_ray(tangents_of(view.fov), view.size, {x + 0.5, y + 0.5});
    const glm::dvec3 p = view.stage_from_eye.translation - ray * (view.stage_from_eye.translation.y / ray.y);
    const glm::dvec3 to_light = at - p;
    const double d = glm::length(to_light), down = to_light.y / d;
    const double cone = std::clamp((down - outer) / (inner - outer), 0.0, 1.0);
    const double window = std::clamp(1 - std::pow(d / range_m, 4), 0.0, 1.0);
    const glm::dvec3 irradiance = glm::dvec3(light.intensity) * (down * cone * cone * window / (d * d));
    const int grey = srgb8(std::min(irradiance.x / std::numbers::pi, 1.0));
    ++checked;
    dark += grey == 0;
    wrong += std::abs(int{shown.pictures[index_of(side)].at(x, y).x} - grey) > 1;
  });
  EXPECT_GT(checked, 20'000u);
  EXPECT_GT(dark, 1000u);
  EXPECT_GT(checked - dark, 5000u);
  EXPECT_EQ(wrong, 0u) << "of " << checked;
}

/// A light so near to a pixel's point that its irradiance is infinite in float. All pixels are in shadow.
TEST_F(Formula, AnInfiniteIrradianceIsDarkInShadow) {
  const StereoView views = eyes_of(head_looking({0, 0, 0.5}, {0, 0, 0}), 192);
  const glm::dvec3 ray = pixel_ray(tangents_of(views[0].fov), views[0].size, {96.5, 96.5});
  const glm::dvec3 point = views[0].stage_from_eye.translation + 0.5 * ray;
  SceneBuilder builder;
  builder.add(quad({0, 0, 0}, {4, 0, 0}, {0, 4, 0}));
  builder.point_light(point + glm::dvec3(0, 0, 1e-5));
  Scene scene = builder.build();
  scene.lights[0].intensity = glm::vec3(1e30f);
  scene.ambient = 0.2f;
  TestRig rig(device_, std::move(scene), 192);
  Mask dark = rig.ask(kTraced, views);
  for (EyeMask& bits : dark.bits) bits = EyeMask(bits.size(), bits.layout());
  const Shown shown = rig.show(views, {dark.traced_mask()}, kPlainReprojection);
  const int grey = srgb8(0.2);
  std::size_t checked = 0, wrong = 0;
  for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
    ++checked;
    wrong += source != 0 || std::abs(int{shown.pictures[index_of(side)].at(x, y).x} - grey) > 1;
  });
  EXPECT_EQ(checked, kEyes * 192 * 192);
  EXPECT_EQ(wrong, 0u);
}

}  // namespace
}  // namespace farshade
