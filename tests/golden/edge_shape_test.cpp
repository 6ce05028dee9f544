/// Shadow edges of many shapes, between pixels: heads that turn by random parts of a pixel see edges that are
/// straight, curved, leafy, crossing, thinner than a pixel, and bent at creases. The visibilities of both
/// eyes are compared with the oracle (tests/oracle), which shares no code with tracer and client.
#include <algorithm>
#include <cstdio>
#include <random>

#include "stereo/raster/frame_data.h"
#include "tests/golden/test_rig.h"
#include "tests/oracle/oracle.h"
#include "tests/oracle/scene_builder.h"
#include "tests/unit/lod/shapes.h"

namespace farshade {
namespace {

constexpr std::uint32_t kShapeSide_px = 112;

/// A caster above a floor. `most` limits the error of four masks, as a share of the nearest pixel's error,
/// and `most_away` the error of pixels without an edge within a pixel, in percent: shadows that are thinner
/// than a pixel can fall between samples.
struct EdgeShape {
  const char* name;
  void (*add)(SceneBuilder& builder);
  double most, most_away = 0.005;
};

std::ostream& operator<<(std::ostream& out, const EdgeShape& shape) {
  return out << shape.name;
}

/// A turn about the y axis.
NodeTransform turned(double angle_rad) {
  NodeTransform transform;
  transform.rotation = glm::angleAxis(angle_rad, glm::dvec3(0, 1, 0));
  return transform;
}

void add_box(SceneBuilder& builder) {
  builder.add(box({0, 0.9f, 0}, {0.5f, 0.1f, 0.4f}));
}

void add_sphere(SceneBuilder& builder) {
  builder.add(grid_mesh(64, 48, [](float u, float v) {
    const float longitude = 6.2831853f * u, latitude = 3.1415927f * v;
    return glm::vec3(0, 0.9f, 0) + 0.4f * glm::vec3(std::sin(latitude) * std::cos(longitude),
                                                    std::cos(latitude),
                                                    std::sin(latitude) * std::sin(longitude));
  }));
}

void add_leaves(SceneBuilder& builder) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> place(-0.6f, 0.6f), size(0.05f, 0.12f), tilt(-0.5f, 0.5f);
  for (int i = 0; i < 40; ++i)
    builder.add(quad({place(random), 0.8f + 0.3f * tilt(random), place(random)},
                     {size(random), 0, tilt(random) * 0.1f}, {0, tilt(random) * 0.1f, -size(random)}));
}

void add_alpha_masked_leaves(SceneBuilder& builder) {
  Texture leaf{.image = Image<Rgba8>({16, 16})};
  for (int i = 0; i < 256; ++i) {
    const double x = i % 16 - 7.5, y = i / 16 - 7.5, inside = 8 * (1 - (x * x + y * y + x * y) / 45);
    leaf.image.pixels[static_cast<std::size_t>(i)].a =
        static_cast<std::uint8_t>(std::clamp(128 + 12 * inside, 0.0, 255.0));
  }
  const std::uint32_t masked =
      builder.material({.name = "leaf", .texture = builder.texture(leaf), .alpha_cutoff = 0.5f});
  std::mt19937 random(12);
  std::uniform_real_distribution<float> place(-0.6f, 0.6f), size(0.1f, 0.2f), tilt(-0.5f, 0.5f);
  for (int i = 0; i < 20; ++i)
    builder.add(quad({place(random), 0.8f + 0.3f * tilt(random), place(random)},
                     {size(random), 0, tilt(random) * 0.1f}, {0, tilt(random) * 0.1f, -size(random)}),
                masked);
}

void add_crossing_rods(SceneBuilder& builder) {
  builder.add(box({0, 0.9f, 0}, {0.8f, 0.04f, 0.04f}));
  builder.add(box({0, 0.7f, 0.1f}, {0.05f, 0.04f, 0.7f}));
  builder.add(box({0.2f, 0.8f, 0}, {0.6f, 0.03f, 0.05f}), 0, turned(0.7));
}

void add_thin_rods(SceneBuilder& builder) {
  for (int i = 0; i < 5; ++i)
    builder.add(box({0.2f * static_cast<float>(i) - 0.4f, 0.6f, 0}, {0.006f, 0.006f, 0.7f}), 0,
                turned(0.1 * i));
}

/// A shadow that bends from the floor to a wall, and a body with faces that are turned away from the lights.
void add_creases(SceneBuilder& builder) {
  builder.add(quad({0, 1, -0.8f}, {2, 0, 0}, {0, 1, 0}));
  builder.add(box({-0.2f, 0.3f, -0.1f}, {0.25f, 0.3f, 0.25f}), 0, turned(0.4));
  builder.add(box({0.5f, 1.1f, -0.2f}, {0.3f, 0.05f, 0.2f}));
}

Scene scene_of(const EdgeShape& shape) {
  SceneBuilder builder;
  builder.add(quad({0, 0, 0}, {2, 0, 0}, {0, 0, -2}));
  shape.add(builder);
  builder.point_light({0.4, 2.3, 0.5});
  builder.directional_light({0.4, -1, -0.3});
  return builder.build();
}

/// Errors of visibilities, of both lights.
struct ShapeErrors {
  double sum = 0;       ///< of |visibility - oracle|
  double far = 0;       ///< the same, of pixels without an edge within a pixel
  std::size_t all = 0;  ///< pixel-lights
};

class EdgeShapes : public OnLavapipe, public testing::WithParamInterface<EdgeShape> {
 protected:
  void add(const Shown& shown, const PerEye<oracle::Masks>& truth, ShapeErrors& errors) const {
    for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t) {
      if (x == 0 || y == 0 || x + 1 == kShapeSide_px || y + 1 == kShapeSide_px) return;
      const std::size_t eye = index_of(side);
      const oracle::Masks& masks = truth[eye];
      for (std::uint32_t light = 0; light < masks.lights; ++light) {
        const std::uint8_t lit = masks.lit[masks.at(x, y, light)];
        const std::size_t pixel = masks.pixel(x, y) * masks.lights + light;
        const double error = std::abs(shown.reports[eye].visibility[pixel] / 255.0 - lit);
        bool near_edge = false;
        for (std::uint32_t j = y - 1; j <= y + 1; ++j)
          for (std::uint32_t i = x - 1; i <= x + 1; ++i)
            near_edge = near_edge || masks.lit[masks.at(i, j, light)] != lit ||
                        masks.in_band[masks.at(i, j, light)] != 0;
        errors.sum += error;
        errors.far += near_edge ? 0 : error;
        ++errors.all;
      }
    });
  }
};

TEST_P(EdgeShapes, AreWhereTheOracleSeesThemAtAnyPartOfAPixel) {
  TestRig rig = TestRig::with_edge_rays(device_, scene_of(GetParam()), kShapeSide_px);
  const Rigid<Stage, Head> head = head_looking({0.3, 1.7, 1.9}, {0, 0.3, 0});
  std::mt19937 random(5);
  std::uniform_real_distribution<double> part(-1, 1);
  ShapeErrors nearest, one_mask, four_masks, rays;
  for (int round = 0; round < 4; ++round) {
    const auto turned = [&](double pixels) {
      const double turn_rad = pixels * 1.1 / kShapeSide_px;
      const Rigid<Head, Head> nod{glm::angleAxis(part(random) * turn_rad, glm::dvec3(1, 0, 0)), {}};
      return rig.eyes(moved(head, turn_rad, {0.001 * pixels, 0, 0}) * nod);
    };
    std::vector<Mask> masks;
    for (std::uint32_t i = 0; i < 4; ++i) masks.push_back(rig.ask({10 - i}, turned(2 * part(random))));
    std::vector<TracedMask> traced;
    for (const Mask& mask : masks) traced.push_back(mask.traced_mask());
    const StereoView now = turned(2 * part(random));
    const SceneState state = state_at(rig.scene(), Time{});
    const PerEye<oracle::Masks> truth{oracle::trace(rig.scene(), state, now[0]),
                                      oracle::trace(rig.scene(), state, now[1])};
    add(rig.show(now, traced), truth, four_masks);
    add(rig.show(now, traced, {.edges = Edges::Exact}), truth, rays);
    add(rig.show(now, {traced[0]}), truth, one_mask);
    add(rig.show(now, traced, {.edges = Edges::Nearest}), truth, nearest);
  }
  const auto percent = [](const ShapeErrors& of, double sum) {
    return 100 * sum / static_cast<double>(of.all);
  };
  std::printf(
      "%s: mask error %.3f %%, with rays %.3f %%, one mask %.3f %%, nearest pixel %.3f %%; away from edges "
      "%.4f %%\n",
      GetParam().name, percent(four_masks, four_masks.sum), percent(rays, rays.sum),
      percent(one_mask, one_mask.sum), percent(nearest, nearest.sum), percent(four_masks, four_masks.far));
  EXPECT_GT(percent(nearest, nearest.sum), 0.2) << "there are edges";
  EXPECT_LT(four_masks.sum, GetParam().most * nearest.sum);
  EXPECT_LT(rays.sum, 0.35 * four_masks.sum);
  EXPECT_LE(one_mask.sum, nearest.sum);
  EXPECT_LE(percent(four_masks, four_masks.far), GetParam().most_away);
}

INSTANTIATE_TEST_SUITE_P(
    , EdgeShapes,
    testing::Values(EdgeShape{"straight", add_box, 0.37}, EdgeShape{"curved", add_sphere, 0.37},
                    EdgeShape{"leafy", add_leaves, 0.48}, EdgeShape{"masked", add_alpha_masked_leaves, 0.48},
                    EdgeShape{"crossing", add_crossing_rods, 0.4},
                    EdgeShape{"thin", add_thin_rods, 0.75, 0.05}, EdgeShape{"creases", add_creases, 0.4}),
    testing::PrintToStringParamName());

}  // namespace
}  // namespace farshade
