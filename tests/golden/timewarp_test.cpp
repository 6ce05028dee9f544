/// Pictures that were made for other views. The device turns them; the result is compared with a reference in
/// double precision and with results computed on paper. A difference picture restores shadows.
#include <cmath>
#include <numbers>
#include <random>

#include "stereo/image/difference.h"
#include "stereo/image/difference_picture.h"
#include "stereo/math/rotation.h"
#include "stereo/reproject/timewarp_pass.h"
#include "tests/golden/test_rig.h"

namespace farshade {
namespace {

using Pictures = PerEye<Image<Rgb8>>;

constexpr Extent kTurnedSize{96, 80};
constexpr double kQuarterTurn_rad = std::numbers::pi / 2;

/// Both eyes at the origin, turned by `turn_rad` about each axis (+y: to the left), with one fov.
StereoView views_of(const glm::dvec3& turn_rad, const EyeFov& fov, Extent size = kTurnedSize) {
  const View view{{rotation_exp(turn_rad), {}}, fov, size};
  return {view, view};
}

EyeFov square_fov(double half_rad) {
  return {-half_rad, half_rad, half_rad, -half_rad};
}

/// A picture that differs between the eyes, between any two heights, and between both sides.
Pictures noise(Extent size, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Pictures pictures{Image<Rgb8>(size), Image<Rgb8>(size)};
  for (Image<Rgb8>& picture : pictures)
    for (Rgb8& pixel : picture.pixels) pixel = Rgb8(random() % 256, random() % 256, random() % 256);
  return pictures;
}

double light_of(double level) {
  const double c = level / 255;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

double level_of(double light) {
  return 255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055);
}

/// The picture at a position, interpolated in linear light.
glm::dvec3 sample(const Image<Rgb8>& picture, glm::dvec2 at) {
  const glm::dvec2 corner = glm::floor(at - 0.5), part = at - 0.5 - corner;
  glm::dvec3 light(0.0);
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const auto x = std::clamp(corner.x + i, 0.0, picture.size.width - 1.0),
                 y = std::clamp(corner.y + j, 0.0, picture.size.height - 1.0);
      const Rgb8 texel = picture.at(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y));
      const double weight = (i == 1 ? part.x : 1 - part.x) * (j == 1 ? part.y : 1 - part.y);
      light += weight * glm::dvec3(light_of(texel.r), light_of(texel.g), light_of(texel.b));
    }
  return {level_of(light.r), level_of(light.g), level_of(light.b)};
}

/// The position in `from` of a shown pixel's direction, computed with the functions of the spaces. No value
/// behind or outside of `from`.
std::optional<glm::dvec2> place_in(const View& from, const View& shown, glm::dvec2 pixel) {
  const Vector<Eye> direction{pixel_ray(tangents_of(shown.fov), shown.size, pixel)};
  const Vector<Eye> there = inverse(from.stage_from_eye)(shown.stage_from_eye(direction));
  if (there.v.z >= 0) return std::nullopt;
  const glm::dvec2 at = ray_pixel(tangents_of(from.fov), from.size, there.v);
  const bool inside = at.x >= 0 && at.y >= 0 && at.x <= from.size.width && at.y <= from.size.height;
  return inside ? std::optional(at) : std::nullopt;
}

/// The number of pixels of `shown` that differ by more than one level from the result in double. Positions on
/// the border may count as inside or outside.
int wrong_pixels(const Image<Rgb8>& shown_picture, const Image<Rgb8>& picture, const View& from,
                 const View& shown) {
  int wrong = 0;
  for (std::uint32_t y = 0; y < shown.size.height; ++y)
    for (std::uint32_t x = 0; x < shown.size.width; ++x) {
      const auto place = place_in(from, shown, {x + 0.5, y + 0.5});
      const glm::dvec3 expected = place ? sample(picture, *place) : glm::dvec3(0.0);
      const glm::dvec3 off = glm::abs(glm::dvec3(shown_picture.at(x, y)) - expected);
      wrong += std::max({off.x, off.y, off.z}) > 1.0;
    }
  return wrong;
}

class Timewarp : public OnLavapipe {
 protected:
  Pictures turned(const Pictures& picture, const StereoView& from, const StereoView& shown) {
    renderer_->show_timewarped(picture, from, shown);
    return renderer_->read_shown();
  }

  Scene scene_ = bundled("box_over_plane.gltf");
  static constexpr Extent kLargest{kTurnedSize.width + 32, kTurnedSize.height + 16};
  std::unique_ptr<Renderer> renderer_ =
      make_renderer(device_, scene_, {.size = kTurnedSize, .traced_size = kLargest, .depth_frames = 1});
};

TEST_F(Timewarp, WithoutATurnThePictureIsTheSameBitForBit) {
  const Pictures picture = noise(kTurnedSize, 1);
  const StereoView views = views_of({0.3, -2.0, 0.1}, {-0.7, 0.5, 0.6, -0.8});
  EXPECT_TRUE(turned(picture, views, views) == picture);
  EXPECT_EQ(outside_share(views, views), (PerEye<double>{0, 0}));
}

TEST_F(Timewarp, EveryPixelIsWhatDoublePrecisionSays) {
  struct Case {
    const char* name;
    glm::dvec3 from_rad, shown_rad;
  };
  const Pictures picture = noise(kTurnedSize, 2);
  for (const Case& turn : {Case{"left", {0, 0, 0}, {0, 0.2, 0}}, Case{"up", {0, 1, 0}, {0.15, 1, 0}},
                           Case{"roll", {0, 0, 0}, {0, 0, 0.4}}, Case{"all", {0.2, 3, -0.1}, {0.1, 2.8, 0.3}},
                           Case{"far", {0, 0, 0}, {0, 1.0, 0}}, Case{"behind", {0, 0, 0}, {0, 3, 0}}}) {
    SCOPED_TRACE(turn.name);
    StereoView from = views_of(turn.from_rad, {-0.7, 0.5, 0.6, -0.8}),
               shown = views_of(turn.shown_rad, {-0.6, 0.65, 0.5, -0.7});
    from[1].fov = {-0.5, 0.7, 0.7, -0.75};
    shown[1].fov = {-0.65, 0.6, 0.55, -0.65};
    shown[0].stage_from_eye.translation = {1, 2, 3};  // must have no effect
    const Pictures result = turned(picture, from, shown);
    const PerEye<double> outside = outside_share(from, shown);
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      EXPECT_LE(wrong_pixels(result[eye], picture[eye], from[eye], shown[eye]), 4) << eye;
      EXPECT_NEAR(static_cast<double>(std::ranges::count(result[eye].pixels, Rgb8(0))) / kTurnedSize.pixels(),
                  outside[eye], 0.001);
    }
  }
}

/// Pictures of several sizes in turn, as a guard band asks for them: larger, smaller, and as large as may be.
TEST_F(Timewarp, APictureMayHaveAnotherSizeThanWhatIsShown) {
  const EyeFov wide{-0.9, 0.7, 0.75, -0.9};
  const StereoView shown = views_of({0.05, 0.1, 0.1}, {-0.7, 0.5, 0.6, -0.8});
  for (const Extent size :
       {Extent{kTurnedSize.width + 16, kTurnedSize.height + 8}, Extent{40, 90}, kLargest}) {
    SCOPED_TRACE(size.width);
    const Pictures picture = noise(size, size.width);
    const StereoView from = views_of({}, wide, size);
    const Pictures result = turned(picture, from, shown);
    for (std::size_t eye = 0; eye < kEyes; ++eye)
      EXPECT_LE(wrong_pixels(result[eye], picture[eye], from[eye], shown[eye]), 4) << eye;
  }
}

/// A guard band on the same pixel grid moves the picture by whole pixels.
TEST_F(Timewarp, AWiderPictureOfTheSamePoseIsCutBitForBit) {
  constexpr Extent wide{kTurnedSize.width + 24, kTurnedSize.height + 16};
  const FovTangents w = tangents_of({-0.7, 0.5, 0.6, -0.8});
  const double x = (w.right_tan - w.left_tan) / kTurnedSize.width,
               y = (w.up_tan - w.down_tan) / kTurnedSize.height;
  const EyeFov fov{std::atan(w.left_tan - 8 * x), std::atan(w.right_tan + 16 * x),
                   std::atan(w.up_tan + 12 * y), std::atan(w.down_tan - 4 * y)};
  const Pictures picture = noise(wide, 4);
  const Pictures result =
      turned(picture, views_of({0.3, 1, 0}, fov, wide), views_of({0.3, 1, 0}, {-0.7, 0.5, 0.6, -0.8}));
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for (std::uint32_t row = 0; row < kTurnedSize.height; ++row)
      for (std::uint32_t column = 0; column < kTurnedSize.width; ++column)
        ASSERT_EQ(result[eye].at(column, row), picture[eye].at(column + 8, row + 12)) << column << " " << row;
}

/// Something seen 45 degrees to the left is 45 degrees to the right after a quarter turn to the left. Each
/// eye has a bar of its own colour there.
TEST_F(Timewarp, AQuarterTurnTakesAMarkerWherePaperSays) {
  const EyeFov fov = square_fov(1.2);
  const double middle = kTurnedSize.width / 2.0, aside = middle / std::tan(1.2);
  const auto before = static_cast<std::uint32_t>(middle - aside), after = kTurnedSize.width - 1 - before;
  const std::array colors{Rgb8(255, 0, 0), Rgb8(0, 255, 0)};
  Pictures picture{Image<Rgb8>(kTurnedSize), Image<Rgb8>(kTurnedSize)};
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for (std::uint32_t y = 0; y < kTurnedSize.height; ++y)
      for (std::uint32_t x = before - 1; x <= before + 1; ++x) picture[eye].at(x, y) = colors[eye];
  const Pictures result = turned(picture, views_of({}, fov), views_of({0, kQuarterTurn_rad, 0}, fov));
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    EXPECT_EQ(result[eye].at(after, kTurnedSize.height / 2), colors[eye]);
    EXPECT_EQ(result[eye].at(after - 6, kTurnedSize.height / 2), Rgb8(0));
    EXPECT_EQ(result[eye].at(after + 6, kTurnedSize.height / 2), Rgb8(0));
    EXPECT_EQ(result[eye].at(before, kTurnedSize.height / 2), Rgb8(0));
  }
}

TEST_F(Timewarp, BordersThatRemainAreAsWideAsPaperSays) {
  const EyeFov narrow = square_fov(std::atan(0.5)), wide = square_fov(std::atan(1.0));
  EXPECT_EQ(outside_share(views_of({}, narrow), views_of({}, wide))[0], 0.75);
  EXPECT_EQ(outside_share(views_of({}, wide), views_of({}, narrow))[0], 0.0);
  EXPECT_EQ(outside_share(views_of({}, wide), views_of({0, kQuarterTurn_rad + 0.01, 0}, wide))[0], 1.0);
  EXPECT_EQ(outside_share(views_of({}, wide), views_of({0, 2 * kQuarterTurn_rad, 0}, wide))[0], 1.0);
  StereoView only_left = views_of({}, wide);
  only_left[0].stage_from_eye.rotation = rotation_exp({0, 2 * kQuarterTurn_rad, 0});
  EXPECT_EQ(outside_share(views_of({}, wide), only_left), (PerEye<double>{1, 0}));
  const Pictures white{Image<Rgb8>(kTurnedSize, Rgb8(255)), Image<Rgb8>(kTurnedSize, Rgb8(255))};
  const Pictures result = turned(white, views_of({}, narrow), views_of({}, wide));
  EXPECT_EQ(std::ranges::count(result[1].pixels, Rgb8(0)), kTurnedSize.pixels() * 3 / 4);
  EXPECT_EQ(result[1].at(kTurnedSize.width / 4 - 1, kTurnedSize.height / 2), Rgb8(0));
  EXPECT_EQ(result[1].at(kTurnedSize.width / 4, kTurnedSize.height / 2), Rgb8(255));
}

TEST_F(Timewarp, WhatIsShownIsTurnedAsIfItHadBeenReadAndLoaded) {
  const StereoView from = eyes_of(head_at_camera(scene_), kTurnedSize.width),
                   shown = eyes_of(moved(head_at_camera(scene_), 0.1, {}), kTurnedSize.width);
  StereoView from_sized = from, shown_sized = shown;
  for (std::size_t eye = 0; eye < kEyes; ++eye) from_sized[eye].size = shown_sized[eye].size = kTurnedSize;
  const SceneState state = state_at(scene_, Time{});
  const auto drawn = [&] {
    renderer_->draw({.views = from_sized, .state = state, .masks = {}, .reprojection = {}});
    return renderer_->read_shown();
  };
  const Pictures loaded = turned(drawn(), from_sized, shown_sized);
  drawn();
  renderer_->timewarp_shown(from_sized, shown_sized);
  const DrawTimes times = renderer_->finish();
  EXPECT_TRUE(renderer_->read_shown() == loaded);
  EXPECT_GT(times.timewarp, Duration{});
  EXPECT_GE(times.total, times.timewarp);
}

TEST_F(Timewarp, CostsNothingUntilAPictureIsTurned) {
  const SceneState state = state_at(scene_, Time{});
  const StereoView views = views_of({}, square_fov(0.7));
  renderer_->draw({.views = views, .state = state, .masks = {}, .reprojection = {}});
  const DrawCounters before = renderer_->counters();
  renderer_->timewarp_shown(views, views);
  const DrawCounters after = renderer_->counters();
  EXPECT_EQ(after.pipelines, before.pipelines + 1);
  EXPECT_EQ(after.bindings, before.bindings + 3);
  EXPECT_GE(after.memory.now[gpu::Use::Shown],
            before.memory.now[gpu::Use::Shown] + kEyes * kLargest.pixels() * 4);
}

TEST(DifferencePicture, HoldsWhatShadowsTakeAwayWithinALevel) {
  Image<Rgb8> with({256, 256}), without({256, 256});
  for (std::uint32_t y = 0; y < 256; ++y)
    for (std::uint32_t x = 0; x < 256; ++x) {
      with.at(x, y) = Rgb8(x, x, 7);
      without.at(x, y) = Rgb8(y, 255 - y, 7);
    }
  const Image<Rgb8> difference = difference_of(with, without);
  for (std::size_t i = 0; i < with.pixels.size(); ++i)
    for (int channel = 0; channel < 3; ++channel)
      ASSERT_NEAR(without.pixels[i][channel] + 2 * (difference.pixels[i][channel] - 128),
                  with.pixels[i][channel], 1);
  EXPECT_EQ(difference.at(0, 0).b, 128) << "equal pictures give mid-grey";
}

class Difference : public OnLavapipe {
 protected:
  static constexpr std::uint32_t kSide_px = 128;

  ShownFrame frame_of(const StereoView& views, std::span<const TracedMask> masks = {}) const {
    return {.views = views, .state = state_, .masks = masks, .reprojection = {.lookup = Lookup::Direct}};
  }
  Pictures drawn(const StereoView& views, std::span<const TracedMask> masks = {}) {
    renderer_->draw(frame_of(views, masks));
    return renderer_->read_shown();
  }
  Pictures reference(const StereoView& views) {
    const Mask truth = rig_.trace(FrameId{1}, views);
    return drawn(views, std::vector{truth.traced_mask()});
  }

  TestRig rig_{device_, bundled("room.glb"), kSide_px};
  SceneState state_ = state_at(rig_.scene(), Time{});
  std::unique_ptr<Renderer> renderer_ =
      make_renderer(device_, rig_.scene(), {{kSide_px, kSide_px}, {kSide_px, kSide_px}, 1});
  StereoView views_ = rig_.eyes(rig_.head());
};

TEST_F(Difference, BringsTheShadowsBack) {
  const Pictures with = reference(views_), without = drawn(views_);
  const Pictures difference{difference_of(with[0], without[0]), difference_of(with[1], without[1])};
  EXPECT_LT(psnr_db(with[0], without[0]), 30.0) << "there are shadows";
  const Mask mask = rig_.trace(FrameId{2}, views_);
  const std::vector masks{mask.traced_mask()};
  renderer_->draw_with_difference(frame_of(views_, masks), difference, views_);
  const Pictures result = renderer_->read_shown();
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for (std::size_t i = 0; i < result[eye].pixels.size(); ++i)
      for (int channel = 0; channel < 3; ++channel)
        ASSERT_NEAR(result[eye].pixels[i][channel], with[eye].pixels[i][channel], 1);
}

TEST_F(Difference, IsTurnedToTheViewsShown) {
  const StereoView turned = rig_.eyes(moved(rig_.head(), 0.1, {}));
  const Pictures with = reference(views_), without = drawn(views_);
  const Pictures difference{difference_of(with[0], without[0]), difference_of(with[1], without[1])};
  const Pictures truth = reference(turned), bare = drawn(turned);
  renderer_->draw_with_difference(frame_of(turned), difference, views_);
  const Pictures result = renderer_->read_shown();
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    EXPECT_GT(psnr_db(result[eye], truth[eye]), psnr_db(bare[eye], truth[eye]) + 3.0);
}

TEST_F(Difference, LeavesWhatItDoesNotCoverWithoutShadows) {
  const StereoView behind = rig_.eyes(moved(rig_.head(), 2 * kQuarterTurn_rad, {}));
  const Pictures bare = drawn(behind);
  renderer_->draw_with_difference(frame_of(behind), noise({kSide_px, kSide_px}, 3), views_);
  EXPECT_TRUE(renderer_->read_shown() == bare);
}

}  // namespace
}  // namespace farshade
