/// The place of shadow edges, against edges that are known on paper (assets/maker/box_over_plane.py): at
/// every shift of the head by a part of a pixel, edges of reprojected masks are nearly where they belong.
#include <cstdio>

#include "stereo/raster/frame_data.h"
#include "tests/golden/test_rig.h"

namespace farshade {
namespace {

constexpr std::uint32_t kSide_px = 256;

/// The direction of a pixel's ray in the stage.
glm::dvec3 ray_of(const View& view, std::uint32_t x, std::uint32_t y) {
  return view.stage_from_eye(Vector<Eye>{pixel_ray(tangents_of(view.fov), view.size, {x + 0.5, y + 0.5})}).v;
}

/// Whether the ray passes the box (slab test).
bool passes_box(const glm::dvec3& eye, const glm::dvec3& ray) {
  const glm::dvec3 a = (glm::dvec3(-0.5, 1, -0.5) - eye) / ray, b = (glm::dvec3(0.5, 1.5, 0.5) - eye) / ray;
  const glm::dvec3 near = glm::min(a, b), far = glm::max(a, b);
  return std::max({near.x, near.y, near.z}) > std::min({far.x, far.y, far.z});
}

/// The point of the plane y = 0 that a pixel shows; none if it shows something else.
std::optional<glm::dvec2> plane_point(const View& view, std::uint32_t x, std::uint32_t y) {
  const glm::dvec3 eye = view.stage_from_eye.translation, ray = ray_of(view, x, y);
  if (ray.y >= 0 || !passes_box(eye, ray)) return std::nullopt;
  const glm::dvec3 p = eye - ray * (eye.y / ray.y);
  if (std::abs(p.x) > 3.9 || std::abs(p.z) > 3.9) return std::nullopt;
  return glm::dvec2(p.x, p.z);
}

/// The bits of the point light and of the directional light.
std::array<bool, 2> on_paper(const glm::dvec2& p) {
  const bool in_point = p.x > -0.95 && p.x < 0.65 && std::abs(p.y) < 0.8;
  const bool in_directional = p.x > 0.5 && p.x < 2 && std::abs(p.y) < 0.5;
  return {!in_point, !in_directional};
}

/// The part of a pixel from which the lights are visible on paper.
std::array<double, 2> coverage_on_paper(const View& view, std::uint32_t x, std::uint32_t y) {
  constexpr std::uint32_t kSide = 8;
  View samples = view;
  samples.size = {view.size.width * kSide, view.size.height * kSide};
  std::array<double, 2> sum{};
  for (std::uint32_t i = 0; i < kSide * kSide; ++i)
    if (const auto p = plane_point(samples, x * kSide + i % kSide, y * kSide + i / kSide))
      for (std::size_t light = 0; light < 2; ++light)
        sum[light] += on_paper(*p)[light] / double{kSide * kSide};
  return sum;
}

/// Sums over pixels that show the plane, and both lights.
struct EdgeSums {
  double wrong = 0;      ///< sum of |visibility - paper|
  double uncovered = 0;  ///< sum of |visibility - part of the pixel on paper|
  double length =
      0;  ///< how often the visibility on paper changes from a pixel to the one beside or below it
  /// The mean distance of an edge from its place, pixels.
  [[nodiscard]] double distance_px() const { return wrong / length; }
};

class EdgePlace : public OnLavapipe {
 protected:
  /// The head has turned by `turn_px` pixels, in a direction that no edge has.
  StereoView turned(double turn_px) const {
    const double turn_rad = turn_px * 1.1 / kSide_px;
    const Rigid<Head, Head> nod{glm::angleAxis(0.37 * turn_rad, glm::dvec3(1, 0, 0)), {}};
    return rig_.eyes(moved(rig_.head(), turn_rad, {0, 0, 0}) * nod);
  }

  void add(const Shown& shown, const StereoView& views, EdgeSums& sums) const {
    for (std::size_t eye = 0; eye < kEyes; ++eye)
      for_pixels({kSide_px - 1, kSide_px - 1}, [&](std::uint32_t x, std::uint32_t y) {
        const auto here = plane_point(views[eye], x, y), beside = plane_point(views[eye], x + 1, y),
                   below = plane_point(views[eye], x, y + 1);
        if (!here || !beside || !below) return;
        const std::size_t pixel = std::size_t{y} * kSide_px + x;
        for (std::size_t light = 0; light < 2; ++light) {
          const bool lit = on_paper(*here)[light];
          const double k = shown.reports[eye].visibility[pixel * 2 + light] / 255.0;
          sums.wrong += std::abs(k - (lit ? 1 : 0));
          const int changes = (lit != on_paper(*beside)[light]) + (lit != on_paper(*below)[light]);
          sums.length += changes;
          if (changes > 0) sums.uncovered += std::abs(k - coverage_on_paper(views[eye], x, y)[light]);
        }
      });
  }

  TestRig rig_{device_, bundled("box_over_plane.gltf"), kSide_px, 8};
};

TEST_F(EdgePlace, IsWithinATenthOfAPixelOnTheMean) {
  EdgeSums nearest, filtered, one_mask, coverage;
  const StereoView now = turned(0);
  for (int eighth = 1; eighth < 8; ++eighth) {
    std::vector<Mask> masks;
    for (std::uint32_t i = 0; i < 4; ++i)
      masks.push_back(rig_.ask({10 - i}, turned((eighth / 8.0 + 1) * (i + 1))));
    std::vector<TracedMask> traced;
    for (const Mask& mask : masks) traced.push_back(mask.traced_mask());
    add(rig_.show(now, traced), now, filtered);
    add(rig_.show(now, {traced[0]}), now, one_mask);
    add(rig_.show(now, traced, {.edges = Edges::Coverage}), now, coverage);
    add(rig_.show(now, traced, {.edges = Edges::Nearest}), now, nearest);
  }
  std::printf("distance of shadow edges from their places, pixels: %.4f; one mask %.4f, nearest pixel %.4f\n",
              filtered.distance_px(), one_mask.distance_px(), nearest.distance_px());
  std::printf(
      "difference from the part of the pixel that is lit: coverage %.4f, filtered %.4f, nearest pixel %.4f\n",
      coverage.uncovered / coverage.length, filtered.uncovered / filtered.length,
      nearest.uncovered / nearest.length);
  EXPECT_GT(nearest.length, 5000);
  EXPECT_LT(coverage.uncovered, 0.8 * filtered.uncovered);
  EXPECT_LT(filtered.distance_px(), 0.1);
  EXPECT_LT(one_mask.distance_px(), nearest.distance_px());
}

TEST_F(EdgePlace, IsWithinAHundredthOfAPixelWithRaysOfTheClient) {
  TestRig rig = TestRig::with_edge_rays(device_, bundled("box_over_plane.gltf"), kSide_px);
  EdgeSums exact;
  const StereoView now = turned(0);
  for (int eighth = 1; eighth < 8; ++eighth) {
    const Mask mask = rig.ask(kTraced, turned(eighth / 8.0 + 1));
    add(rig.show(now, {mask.traced_mask()}, {.edges = Edges::Exact}), now, exact);
  }
  std::printf("distance of shadow edges from their places with rays, pixels: %.5f\n", exact.distance_px());
  EXPECT_GT(exact.length, 5000);
  EXPECT_LT(exact.distance_px(), 0.01);
}

/// Errors of the visibilities of the first eight lights, and of all others.
using ErrorSums = std::array<double, 2>;

ErrorSums errors_of(const Shown& shown, const Mask& truth) {
  ErrorSums sums{};
  const std::uint32_t lights = truth.bits[0].lights();
  for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t) {
    const std::size_t eye = index_of(side), pixel = std::size_t{y} * truth.bits[eye].size().width + x;
    for (std::uint32_t light = 0; light < lights; ++light) {
      const bool lit = (truth.bits[eye].word(x, y, light / 32) >> light % 32 & 1u) != 0;
      sums[light < 8 ? 0 : 1] +=
          std::abs(shown.reports[eye].visibility[pixel * lights + light] / 255.0 - (lit ? 1 : 0));
    }
  });
  return sums;
}

// Eight lights are looked up together: the second group is no worse than the first.
TEST_F(EdgePlace, IsAsGoodForLightsBeyondTheFirstEight) {
  TestRig rig(device_, with_lights(bundled("room.glb"), 12), 192, 8);
  const auto turned_by = [&](double degrees) {
    return rig.eyes(moved(rig.head(), degrees / 57.3, {0.002 * degrees, 0, 0}));
  };
  std::vector<Mask> masks;
  for (std::uint32_t i = 0; i < 4; ++i) masks.push_back(rig.ask({10 - i}, turned_by(0.37 * (i + 1))));
  std::vector<TracedMask> traced;
  for (const Mask& mask : masks) traced.push_back(mask.traced_mask());
  const StereoView now = turned_by(0);
  const Mask truth = rig.trace(kNow, now);
  const ErrorSums line = errors_of(rig.show(now, traced), truth),
                  nearest = errors_of(rig.show(now, traced, {.edges = Edges::Nearest}), truth);
  for (std::size_t group = 0; group < 2; ++group) {
    EXPECT_GT(nearest[group], 100) << "there are edges";
    EXPECT_LT(line[group], 0.85 * nearest[group]) << "group " << group;
  }
}

}  // namespace
}  // namespace farshade
