// Pictures with levels of detail: close to full detail, with fewer triangles, and without popping.
// Detail::Full is full detail to the bit.
#include <gtest/gtest.h>

#include <algorithm>

#include "stereo/gltf/gltf.h"
#include "stereo/image/difference.h"
#include "tests/golden/test_rig.h"
#include "tests/oracle/scene_builder.h"
#include "tests/unit/lod/shapes.h"

namespace farshade {
namespace {

constexpr std::uint32_t kDetailSide_px = 256;
constexpr RendererLimits kDetailLimits{{kDetailSide_px, kDetailSide_px}, {kDetailSide_px, kDetailSide_px}, 1};

class LevelsInPictures : public OnLavapipe {
 protected:
  /// A renderer with levels whose error is at most `detail_px`; with 0, one without levels.
  [[nodiscard]] std::unique_ptr<Renderer> renderer(float detail_px) const {
    DrawPlan plan = plan_for(scene_, {.all_lights = true}).draw;
    plan.detail_px = detail_px;
    return make_renderer(device_, scene_, plan, kDetailLimits, detail_px > 0 ? levels_ : SceneLevels{});
  }

  struct Drawn {
    PerEye<Image<Rgb8>> eyes;
    std::uint64_t triangles = 0;  ///< of the G-buffer
  };
  Drawn draw(Renderer& with, const StereoView& views, Detail detail) const {
    with.draw({.views = views, .state = state_, .masks = {}, .reprojection = {}, .detail = detail});
    const DrawTimes drawn = with.finish();
    return {with.read_shown(), drawn.triangles.gbuffer};
  }

  /// The head on a slow walk from the scene's camera into the room.
  [[nodiscard]] StereoView step(int i) const {
    return eyes_of(moved(head_at_camera(scene_), 0.004 * i, {0.002 * i, 0, -0.02 * i}), kDetailSide_px);
  }

  const Scene scene_ = bundled("room.glb");
  const SceneState state_ = state_at(scene_, Time{});
  const SceneLevels levels_ = make_levels(scene_);
};

TEST_F(LevelsInPictures, FullDetailIsTheSameWithAndWithoutLevels) {
  const auto with = renderer(0.25f), without = renderer(0);
  for (const int i : {0, 20}) {
    const Drawn a = draw(*with, step(i), Detail::Full), b = draw(*without, step(i), Detail::Levels);
    for (std::size_t eye = 0; eye < kEyes; ++eye) EXPECT_TRUE(a.eyes[eye].pixels == b.eyes[eye].pixels) << i;
    EXPECT_EQ(a.triangles, b.triangles) << i;
  }
}

TEST_F(LevelsInPictures, AreCloseToFullDetailAndCloserTheSmallerTheLimit) {
  const auto full = renderer(0);
  const Drawn right = draw(*full, step(0), Detail::Full);
  double psnr = 99;
  std::uint64_t triangles = right.triangles;
  for (const float limit_px : {0.0625f, 0.25f, 1.0f}) {
    const auto with = renderer(limit_px);
    const Drawn shown = draw(*with, step(0), Detail::Levels);
    const double now = std::min(psnr_db(shown.eyes[0], right.eyes[0]), psnr_db(shown.eyes[1], right.eyes[1]));
    EXPECT_LT(shown.triangles, triangles) << limit_px;
    EXPECT_LT(now, psnr) << limit_px;
    triangles = shown.triangles;
    psnr = now;
    if (limit_px < 1) {
      EXPECT_GT(now, 40) << limit_px;
    }
  }
  EXPECT_LT(triangles, right.triangles * 9 / 10);
}

/// The value that all but one in a thousand differences of two pictures stay below, of 255.
int usual_change(const Image<Rgb8>& a, const Image<Rgb8>& b) {
  std::vector<int> changes;
  for (std::size_t i = 0; i < a.pixels.size(); ++i)
    changes.push_back(
        std::max({std::abs(a.pixels[i].r - b.pixels[i].r), std::abs(a.pixels[i].g - b.pixels[i].g),
                  std::abs(a.pixels[i].b - b.pixels[i].b)}));
  const auto rank = changes.end() - static_cast<std::ptrdiff_t>(changes.size() / 1000);
  std::nth_element(changes.begin(), rank, changes.end());
  return *rank;
}

double mean_change(const Image<Rgb8>& a, const Image<Rgb8>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i)
    for (glm::length_t c = 0; c < 3; ++c) sum += std::abs(a.pixels[i][c] - b.pixels[i][c]);
  return sum / (3.0 * static_cast<double>(a.pixels.size()));
}

// Between two frames the picture changes as much as in full detail, also where levels change.
TEST_F(LevelsInPictures, DoNotPop) {
  const auto with = renderer(kDefaultDetail_px), full = renderer(0);
  int switches = 0;
  Drawn before, full_before;
  for (int i = 0; i < 24; ++i) {
    const Drawn now = draw(*with, step(i), Detail::Levels), full_now = draw(*full, step(i), Detail::Full);
    const bool switched = i > 0 && now.triangles != before.triangles;
    for (std::size_t eye = 0; switched && eye < kEyes; ++eye) {
      const Image<Rgb8>&shown = now.eyes[eye], &shown_before = before.eyes[eye], &right = full_now.eyes[eye],
            &right_before = full_before.eyes[eye];
      EXPECT_LE(usual_change(shown, shown_before), usual_change(right, right_before) + 8) << i;
      EXPECT_LE(mean_change(shown, shown_before), 1.1 * mean_change(right, right_before)) << i;
    }
    switches += switched;
    before = now;
    full_before = full_now;
  }
  EXPECT_GE(switches, 6) << "levels change on this walk";
}

// A head that trembles does not switch levels to and fro.
TEST_F(LevelsInPictures, DoNotFlicker) {
  const auto with = renderer(kDefaultDetail_px);
  int switches = 0;
  std::uint64_t triangles = 0;
  for (int i = 0; i < 16; ++i) {
    const StereoView views =
        eyes_of(moved(head_at_camera(scene_), 0, {0, 0, i % 2 == 0 ? -0.005 : 0.005}), kDetailSide_px);
    const Drawn now = draw(*with, views, Detail::Levels);
    switches += i > 2 && now.triangles != triangles;
    triangles = now.triangles;
  }
  EXPECT_EQ(switches, 0);
}

/// The head is inside of one large mesh, so a cluster that is wrongly left out would be a hole.
TEST_F(OnLavapipe, ClustersOutsideOfTheViewsAreLeftOut) {
  SceneBuilder builder;
  Material material;
  material.double_sided = true;
  Mesh sphere = grid_mesh(128, 96, [](float u, float v) {
    const float longitude = 6.2831853f * u, latitude = 3.1415927f * v;
    return glm::vec3(std::sin(latitude) * std::cos(longitude), std::cos(latitude),
                     std::sin(latitude) * std::sin(longitude));
  });
  const std::size_t triangles = sphere.triangles.size();
  builder.add(std::move(sphere), builder.material(material));
  builder.point_light({0, 0, 0});
  const Scene scene = builder.build();
  const std::unique_ptr<Renderer> renderer_owner = make_renderer(device_, scene, kDetailLimits);
  Renderer& renderer = *renderer_owner;
  for (int direction = 0; direction < 7; ++direction) {
    const auto head = moved({}, 0.9 * direction, {0.3, 0.1 * direction, 0});
    renderer.draw({.views = eyes_of(head, kDetailSide_px),
                   .state = state_at(scene, Time{}),
                   .masks = {},
                   .reprojection = {}});
    const DrawTimes drawn = renderer.finish();
    for (const Image<float>& eye : renderer.read_distance())
      EXPECT_GT(*std::ranges::min_element(eye.pixels), 0) << direction;
    EXPECT_LT(drawn.triangles.gbuffer, triangles) << "half of both eyes' triangles";
  }
}

}  // namespace
}  // namespace farshade
