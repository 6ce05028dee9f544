/// Compares the shaders' float reprojection with a reference in double: the positions of points in traced
/// views, and whether those views saw the points.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "stereo/base/quantile.h"
#include "tests/golden/pose_cases.h"
#include "tests/golden/reproject_reference.h"
#include "tests/golden/test_rig.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

constexpr std::uint32_t kReferenceSide_px = 192;

/// Uses only the newest mask that was traced for this eye. Other points are unknown.
constexpr Reprojection kOneView{.eyes = Eyes::This, .gaps = Gaps::Unknown, .edges = Edges::Nearest};

/// The largest allowed error of the float positions. Measured: 7e-5 px.
constexpr double kMostOff_px = 1e-3;

/// Compares the float and the double results over both eyes of some pairs of views. Counts are of shown
/// pixels.
struct Against {
  std::vector<double> off_px;           ///< error of every pixel that was found in the traced view
  std::size_t same = 0, refused = 0;    ///< clearly the same surface; how many of them were not found
  std::size_t other = 0, accepted = 0;  ///< clearly another surface; how many of them were found
  std::size_t hidden = 0;               ///< of `other`, within the traced view
};

void compare_pixel(const EyeDepth& shown, const EyeDepth& traced, const ShownReport& report, std::size_t i,
                   Against& against) {
  const auto x = static_cast<std::uint32_t>(i % shown.view.size.width),
             y = static_cast<std::uint32_t>(i / shown.view.size.width);
  const bool found = report.sources[i] == 0;
  const std::optional<ReprojectedPixel> reprojected = reproject(shown, x, y, traced.view);
  if (found) {
    const glm::dvec2 at(report.positions[i][0], report.positions[i][1]);
    against.off_px.push_back(reprojected ? glm::length(reprojected->at - at) : HUGE_VAL);
  }
  const SameSurface same = same_surface(shown, x, y, traced);
  against.same += same == SameSurface::Yes;
  against.other += same == SameSurface::No;
  against.refused += same == SameSurface::Yes && !found;
  against.accepted += same == SameSurface::No && found;
  against.hidden += same == SameSurface::No && reprojected && is_inside(reprojected->at, traced.view.size);
}

void compare(TestRig& rig, const PoseViews& views, Against& against) {
  const Mask mask = rig.ask(kTraced, views.traced);
  const PerEye<Image<float>> traced = rig.requested_distance();
  const Shown now = rig.show(views.shown, {mask.traced_mask()}, kOneView);
  const PerEye<Image<float>> shown = rig.renderer().read_distance();
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const EyeDepth of_shown{views.shown[eye], shown[eye]}, of_traced{views.traced[eye], traced[eye]};
    for (std::size_t i = 0; i < now.reports[eye].sources.size(); ++i)
      if (now.reports[eye].sources[i] != kSourceUncovered)
        compare_pixel(of_shown, of_traced, now.reports[eye], i, against);
  }
}

struct Place {
  const char* name;
  Scene (*scene)();
};

std::ostream& operator<<(std::ostream& out, const Place& place) {
  return out << place.name;
}

/// A box over a plane, more than 1,000 km from the origin.
Scene far_away() {
  const glm::dvec3 origin{1e6, 2e3, -7e5};
  SceneBuilder builder(origin);
  builder.add(quad({0, 0, 0}, {0, 0, 4}, {4, 0, 0}));
  builder.add(box({0, 0.6, 0}, {0.3, 0.3, 0.3}));
  builder.point_light({0.8, 2, 0.5});
  Scene scene = builder.build();
  scene.camera = look(origin + glm::dvec3(0.5, 1.6, 2.5), origin + glm::dvec3(0, 0.4, 0), 1).stage_from_eye;
  return scene;
}

class ReprojectReference : public OnLavapipe, public testing::WithParamInterface<Place> {
 protected:
  void expect_agreement(Against& against) {
    ASSERT_GT(against.off_px.size(), 1'000u);
    const double largest = *std::max_element(against.off_px.begin(), against.off_px.end()),
                 p99 = quantile(against.off_px, 0.99);
    fmt::print(
        "{} found, off by {:.1e} px at most, p99 {:.1e}; clear: {} same, {} other, {} of them hidden\n",
        against.off_px.size(), largest, p99, against.same, against.other, against.hidden);
    EXPECT_LT(largest, kMostOff_px);
    EXPECT_GT(against.same, against.off_px.size() / 2);
    EXPECT_EQ(against.refused, 0u) << "of " << against.same;
    EXPECT_EQ(against.accepted, 0u) << "of " << against.other;
  }

  TestRig rig_{device_, GetParam().scene(), kReferenceSide_px};
};

TEST_P(ReprojectReference, AgreesWithFloatForAllPoses) {
  Against against;
  for (const PoseCase& pose : pose_cases())
    compare(rig_, views_of(pose, rig_.head(), kReferenceSide_px), against);
  expect_agreement(against);
  EXPECT_GT(against.hidden, 100u);
}

TEST_P(ReprojectReference, AgreesWithFloatForFovsOf1And170Degrees) {
  for (const double fov_degrees : {1.0, 170.0}) {
    SCOPED_TRACE(fov_degrees);
    const double half_rad = fov_degrees / 2 * std::numbers::pi / 180;
    Against against;
    // These turns are smaller than the fov: a view of 1 degree shares nothing with one that is turned by 5.
    for (const double share : {0.1, -0.3})
      compare(rig_,
              views_of({.name = "",
                        .yaw_degrees = std::min(20.0, fov_degrees) * share,
                        .step_m = 0.1 * share,
                        .left_fov = {-half_rad, half_rad, half_rad, -half_rad}},
                       rig_.head(), kReferenceSide_px),
              against);
    expect_agreement(against);
  }
}

INSTANTIATE_TEST_SUITE_P(
    , ReprojectReference,
    testing::Values(Place{"box_over_plane", [] { return bundled("box_over_plane.gltf"); }},
                    Place{"room", [] { return bundled("room.glb"); }}, Place{"far_from_origin", far_away}),
    [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace farshade
