/// Edge rays: the client's own rays decide at shadow edges (Edges::Exact), against full traces of what is
/// shown.
#include <cmath>
#include <cstdio>
#include <numbers>

#include <random>

#include "tests/golden/test_rig.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kSide_px = 256;
constexpr Reprojection kExact{.edges = Edges::Exact}, kLine{.edges = Edges::Line};

/// The mean error of visibilities at pixels that the newest mask of their eye knows.
double error_of(const Shown& shown, const Mask& truth) {
  const std::size_t lights = truth.bits[0].lights();
  double wrong = 0, total = 0;
  for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
    if (source != 0) return;
    const std::size_t pixel = std::size_t{y} * kSide_px + x;
    for (std::uint32_t light = 0; light < lights; ++light) {
      const double k = shown.reports[index_of(side)].visibility[pixel * lights + light] / 255.0;
      wrong += std::abs(k - truth.bits[index_of(side)].lit(x, y, light));
      ++total;
    }
  });
  return wrong / total;
}

/// Whether the four pixels of a mask around a position differ in a light.
bool mixed_about(const EyeMask& mask, const std::array<float, 2>& at, std::uint32_t light) {
  int pixels = 0, lit = 0;
  for (int tap = 0; tap < 4; ++tap) {
    const int x = static_cast<int>(std::floor(at[0] - 0.5f)) + tap % 2,
              y = static_cast<int>(std::floor(at[1] - 0.5f)) + tap / 2;
    const auto width = static_cast<int>(mask.size().width), height = static_cast<int>(mask.size().height);
    if (x < 0 || y < 0 || x >= width || y >= height) continue;
    ++pixels;
    lit += mask.lit(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), light) ? 1 : 0;
  }
  return lit > 0 && lit < pixels;
}

/// Pixels and lights for which a ray decides, and the sum of the errors there.
struct RayErrors {
  double wrong = 0;
  std::size_t rays = 0;
};

RayErrors ray_errors(const Shown& shown, const Mask& newest, const Mask& truth) {
  RayErrors sum;
  const std::size_t lights = truth.bits[0].lights();
  for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
    if (source != 0) return;
    const ShownReport& report = shown.reports[index_of(side)];
    const std::size_t pixel = std::size_t{y} * kSide_px + x;
    for (std::uint32_t light = 0; light < lights; ++light) {
      if (!mixed_about(newest.bits[index_of(side)], report.positions[pixel], light)) continue;
      const double k = report.visibility[pixel * lights + light] / 255.0;
      sum.wrong += std::abs(k - truth.bits[index_of(side)].lit(x, y, light));
      ++sum.rays;
    }
  });
  return sum;
}

bool same_visibility(const Shown& a, const Shown& b) {
  return a.reports[0].visibility == b.reports[0].visibility &&
         a.reports[1].visibility == b.reports[1].visibility;
}

class EdgeRaysIn : public OnLavapipe {
 protected:
  /// Masks of the poses before, newest first.
  static std::vector<Mask> masks_of(TestRig& rig, const std::function<Rigid<Stage, Head>(double)>& head_at) {
    std::vector<Mask> masks;
    for (std::uint32_t i = 0; i < 4; ++i) masks.push_back(rig.ask({10 - i}, rig.eyes(head_at(1 + 0.37 * i))));
    return masks;
  }

  static std::vector<TracedMask> traced(const std::vector<Mask>& masks) {
    std::vector<TracedMask> result;
    for (const Mask& mask : masks) result.push_back(mask.traced_mask());
    return result;
  }

  struct Errors {
    double line, exact;
    RayErrors of_rays;
  };
  static Errors errors(TestRig& rig, const glm::dvec3& step_m, double yaw_rad) {
    const auto head_at = [&](double times) { return moved(rig.head(), yaw_rad * times, step_m * times); };
    const std::vector<Mask> masks = masks_of(rig, head_at);
    const StereoView now = rig.eyes(head_at(0));
    const Mask truth = rig.trace(kNow, now);
    const Shown exact = rig.show(now, traced(masks), kExact);
    return {error_of(rig.show(now, traced(masks), kLine), truth), error_of(exact, truth),
            ray_errors(exact, masks[0], truth)};
  }
};

/// The room without its animation.
Scene still_room() {
  Scene scene = bundled("room.glb");
  for (Node& node : scene.nodes) node.moving = false;
  scene.channels.clear();
  return scene;
}

/// Most of what is left is in cells that have no edge: shadows and gaps thinner than a pixel.
TEST_F(EdgeRaysIn, ARoomAtRestAreRightAndLeaveAFifthOfTheError) {
  TestRig rig = TestRig::with_edge_rays(device_, still_room(), kSide_px);
  const Errors turned = errors(rig, {0, 0, 0}, 0.02), stepped = errors(rig, {0.02, 0.01, 0}, 0.003);
  std::printf("mask error in the room, %%: line %.4f and %.4f, rays %.4f and %.4f\n", 100 * turned.line,
              100 * stepped.line, 100 * turned.exact, 100 * stepped.exact);
  for (const Errors& errors : {turned, stepped}) {
    EXPECT_LT(errors.exact, errors.line / 5);
    EXPECT_GT(errors.of_rays.rays, 30000u);
    EXPECT_LT(errors.of_rays.wrong, 0.0025 * static_cast<double>(errors.of_rays.rays));
  }
}

TEST_F(EdgeRaysIn, ARoomThatMovesAreBetterThanALine) {
  TestRig rig = TestRig::with_edge_rays(device_, bundled("room.glb"), kSide_px);
  const auto head_at = [&](double times) { return moved(rig.head(), 0.003 * times, {0.02 * times, 0, 0}); };
  std::vector<Mask> masks;
  for (std::uint32_t i = 0; i < 4; ++i) {
    rig.set_time(Time(650ms + 28ms * i));
    masks.insert(masks.begin(), rig.ask({i + 1}, rig.eyes(head_at(4.0 - i))));
  }
  rig.set_time(Time(650ms + 28ms * 4));
  const StereoView now = rig.eyes(head_at(0));
  const Mask truth = rig.trace({20}, now);
  const double line = error_of(rig.show(now, traced(masks), kLine), truth),
               exact = error_of(rig.show(now, traced(masks), kExact), truth);
  std::printf("mask error in the moving room, %%: line %.4f, rays %.4f\n", 100 * line, 100 * exact);
  EXPECT_LT(exact, 0.8 * line);
}

/// Bits that the server has traced for this very point stay.
TEST_F(EdgeRaysIn, AViewThatRestsChangeNothing) {
  TestRig rig = TestRig::with_edge_rays(device_, bundled("room.glb"), kSide_px);
  const StereoView views = rig.eyes(rig.head());
  const Mask mask = rig.ask(kTraced, views);
  const Shown exact = rig.show(views, {mask.traced_mask()}, kExact),
              nearest = rig.show(views, {mask.traced_mask()}, {.edges = Edges::Nearest});
  EXPECT_TRUE(same_visibility(exact, nearest));
}

/// A light that the viewer has moved has no buffer, so pixels at its edges are shaded as without rays.
TEST_F(EdgeRaysIn, AScenesWhoseLightsWereMovedDecideNothing) {
  Scene scene = bundled("box_over_plane.gltf");
  const std::size_t lights = scene.lights.size();
  TestRig rig = TestRig::with_edge_rays(device_, std::move(scene), kSide_px);
  const auto head_at = [&](double times) { return moved(rig.head(), 0.004 * times, {0.013 * times, 0, 0}); };
  const StereoView now = rig.eyes(head_at(0));
  const std::vector<Mask> before = masks_of(rig, head_at);
  EXPECT_FALSE(same_visibility(rig.show(now, traced(before), kExact), rig.show(now, traced(before), kLine)));
  LightChanges changes;
  for (std::uint32_t i = 0; i < lights; ++i)
    change(changes, i, true, LightPose{Point<Stage>{{0.3, 2.6, 0.2}}, Vector<Stage>{{0.6, -0.8, 0}}});
  rig.set_lights(changes);
  const std::vector<Mask> after = masks_of(rig, head_at);
  EXPECT_TRUE(same_visibility(rig.show(now, traced(after), kExact), rig.show(now, traced(after), kLine)));
}

/// On a device whose buffers of texels are too small for them, lights have no buffers.
TEST_F(EdgeRaysIn, ASmallDeviceFallBackToTheLine) {
  const auto shown_with = [&](std::uint64_t max_texels, const Reprojection& reprojection) {
    device_.max_texels = max_texels;
    TestRig rig = TestRig::with_edge_rays(device_, bundled("box_over_plane.gltf"), kSide_px);
    const auto head_at = [&](double times) {
      return moved(rig.head(), 0.004 * times, {0.013 * times, 0, 0});
    };
    return rig.show(rig.eyes(head_at(0)), traced(masks_of(rig, head_at)), reprojection);
  };
  const Shown line = shown_with(1'000'000, kLine);
  EXPECT_TRUE(same_visibility(shown_with(10, kExact), line)) << "the triangles do not fit";
  EXPECT_TRUE(same_visibility(shown_with(3'000, kExact), line)) << "the triangles fit, and no light does";
  EXPECT_FALSE(same_visibility(shown_with(1'000'000, kExact), line));
}

TEST_F(EdgeRaysIn, DataThatComeLaterFollowTheLine) {
  std::promise<EdgeRayData> data;
  const Scene scene = bundled("box_over_plane.gltf");
  TestRig rig = TestRig::with_edge_rays(device_, scene, kSide_px, data.get_future().share()),
          line = TestRig::with_edge_rays(device_, scene, kSide_px, FutureEdgeRayData()),
          at_once = TestRig::with_edge_rays(device_, scene, kSide_px);
  const auto head_at = [&](double times) { return moved(rig.head(), 0.004 * times, {0.013 * times, 0, 0}); };
  const auto show = [&](TestRig& its, double times, const Reprojection& reprojection) {
    return its.show(its.eyes(head_at(times)), traced(masks_of(its, head_at)), reprojection);
  };
  for (const double times : {0.0, 1.0})  // at 1 the view is that of the newest mask
    EXPECT_EQ(show(rig, times, kExact).pictures, show(line, times, kLine).pictures) << times;
  data.set_value(edge_ray_data(device_, scene));
  for (const double times : {0.0, 1.0})
    EXPECT_EQ(show(rig, times, kExact).pictures, show(at_once, times, kExact).pictures) << times;
  EXPECT_NE(show(rig, 0, kExact).pictures, show(line, 0, kLine).pictures);
}

/// The device was opened again, and is another one.
TEST_F(EdgeRaysIn, ADeviceThatIsTooSmallForTheDataFallBackToTheLine) {
  std::promise<EdgeRayData> data;
  const Scene scene = bundled("box_over_plane.gltf");
  TestRig rig = TestRig::with_edge_rays(device_, scene, kSide_px, data.get_future().share());
  const auto head_at = [&](double times) { return moved(rig.head(), 0.004 * times, {0.013 * times, 0, 0}); };
  const StereoView now = rig.eyes(head_at(0));
  const std::vector<Mask> masks = masks_of(rig, head_at);
  const Shown line = rig.show(now, traced(masks), kLine);
  data.set_value(edge_ray_data(device_, scene));
  device_.max_texels = 3'000;
  EXPECT_TRUE(same_visibility(rig.show(now, traced(masks), kExact), line));
  EXPECT_TRUE(same_visibility(rig.show(now, traced(masks), kExact), line));
}

/// Point lights in a ring above the box.
Scene box_under_lights(std::uint32_t count) {
  Scene scene = bundled("box_over_plane.gltf");
  scene.lights.clear();
  for (std::uint32_t i = 0; i < count; ++i) {
    const double turn = 2 * std::numbers::pi * i / count;
    Node node;
    node.rest.translation = {2 * std::cos(turn), 2.5, 2 * std::sin(turn)};
    LightSource light;
    light.node = static_cast<std::uint32_t>(scene.nodes.size());
    scene.lights.push_back(light);
    scene.nodes.push_back(node);
  }
  return scene;
}

/// Lights of two planes of a mask.
TEST_F(EdgeRaysIn, ASceneOfFortyLightsAreRight) {
  TestRig rig = TestRig::with_edge_rays(device_, box_under_lights(40), kSide_px);
  const Errors errors = this->errors(rig, {0.02, 0.01, 0}, 0.003);
  EXPECT_LT(errors.exact, errors.line / 5);
  EXPECT_GT(errors.of_rays.rays, 30000u);
  EXPECT_LT(errors.of_rays.wrong, 0.0025 * static_cast<double>(errors.of_rays.rays));
}

/// Points that the newest mask did not see have rays to all lights, and no other mask is asked.
TEST_F(EdgeRaysIn, ARevealedFloorAreRightAtOnce) {
  TestRig rig = TestRig::with_edge_rays(device_, box_under_lights(3), kSide_px);
  const auto head_at = [&](double times) { return moved(rig.head(), 0.05 * times, {0.15 * times, 0, 0}); };
  const std::vector<Mask> masks = masks_of(rig, head_at);
  const StereoView now = rig.eyes(head_at(0));
  const Mask truth = rig.trace(kNow, now);
  const Shown shown = rig.show(now, traced(masks), kExact);
  std::size_t rays = 0, wrong = 0, others = 0, lit = 0;
  for_covered(shown, [&](Side side, std::uint32_t x, std::uint32_t y, std::uint8_t source) {
    others += source != 0 && source != kSourceRays;
    if (source != kSourceRays) return;
    const std::size_t pixel = std::size_t{y} * kSide_px + x;
    const ShownReport& report = shown.reports[index_of(side)];
    EXPECT_EQ(report.unknown[pixel], 0u);
    for (std::uint32_t light = 0; light < 3; ++light) {
      const bool is_lit = truth.bits[index_of(side)].lit(x, y, light);
      ++rays;
      lit += is_lit;
      wrong += (report.visibility[pixel * 3 + light] != 0) != is_lit;
    }
  });
  EXPECT_GT(rays, 3000u);
  EXPECT_LT(lit, rays * 9 / 10);
  EXPECT_LT(wrong, rays / 400);
  EXPECT_EQ(others, 0u);
}

/// Random alphas of `side` x `side` texels.
Texture random_alphas(std::uint32_t side, Wrap wrap_u, Wrap wrap_v, std::mt19937& random) {
  Texture texture{.image = Image<Rgba8>({side, side + 1}), .wrap_u = wrap_u, .wrap_v = wrap_v};
  for (Rgba8& texel : texture.image.pixels) texel.a = static_cast<std::uint8_t>(random() % 256);
  return texture;
}

/// Cloths with holes above a floor: three with textures of each wrap, one that has only alpha of vertices,
/// and one below these. Below it is a rod without holes. Vertices have alpha on each cloth. A texel is about
/// six pixels wide.
Scene torn_cloths(std::uint32_t texture_side) {
  SceneBuilder builder;
  builder.add(quad({0, 0, 0}, {3, 0, 0}, {0, 0, -3}));
  std::mt19937 random(7);
  const auto add = [&](const glm::vec3& center, std::optional<std::uint32_t> texture) {
    Mesh cloth = quad(center, {0.4f, 0.1f, 0}, {0, 0.05f, -0.35f}, 2.3f);
    for (glm::vec2& uv : cloth.uvs) uv -= glm::vec2(0.7f, 0.4f);
    for (std::size_t i = 0; i < cloth.positions.size(); ++i)
      cloth.colors.emplace_back(255, 255, 255, 255 - random() % 90);
    if (!texture)
      for (std::size_t i = 0; i < cloth.colors.size(); i += 2) cloth.colors[i].a = 30;
    builder.add(
        cloth,
        builder.material(
            {.name = "cloth", .base_color = {1, 1, 1, 0.95f}, .texture = texture, .alpha_cutoff = 0.4f}));
  };
  const auto texture = [&](Wrap wrap_u, Wrap wrap_v) {
    return builder.texture(random_alphas(texture_side, wrap_u, wrap_v, random));
  };
  add({-0.5f, 0.9f, -0.4f}, texture(Wrap::Repeat, Wrap::MirroredRepeat));
  add({0.5f, 0.9f, -0.4f}, texture(Wrap::MirroredRepeat, Wrap::ClampToEdge));
  add({-0.5f, 0.9f, 0.4f}, texture(Wrap::ClampToEdge, Wrap::Repeat));
  add({0.5f, 0.9f, 0.4f}, std::nullopt);
  add({0.1f, 0.6f, 0.1f}, texture(Wrap::Repeat, Wrap::Repeat));
  builder.add(box({0, 0.4f, 0.05f}, {0.9f, 0.03f, 0.03f}));
  builder.point_light({0.3, 3, 0.2});
  builder.directional_light({0.3, -1, -0.2});
  builder.spot_light({-0.4, 2.8, 0.5}, {0.1, -1, -0.1}, 0.7f);
  Scene scene = builder.build();
  scene.camera = look({0.2, 1.8, 2.0}, {0, 0.2, 0}, 1).stage_from_eye;
  return scene;
}

TEST_F(EdgeRaysIn, AlphaMaskedCastersAreRight) {
  TestRig rig = TestRig::with_edge_rays(device_, torn_cloths(5), kSide_px);
  const Errors errors = this->errors(rig, {0.02, 0.01, 0}, 0.003);
  std::printf("mask error under torn cloths, %%: line %.4f, rays %.4f, where they decide %.4f of %zu\n",
              100 * errors.line, 100 * errors.exact,
              100 * errors.of_rays.wrong / static_cast<double>(errors.of_rays.rays), errors.of_rays.rays);
  EXPECT_LT(errors.exact, errors.line / 3);
  EXPECT_GT(errors.of_rays.rays, 10000u);
  EXPECT_LT(errors.of_rays.wrong, 0.0025 * static_cast<double>(errors.of_rays.rays));
}

/// Where only a triangle whose alpha is not on the device stops a ray, it decides nothing.
TEST_F(EdgeRaysIn, AlphaMaskedCastersWhoseTexturesDoNotFitHaveTheLine) {
  const auto errors_with = [&](std::uint64_t max_texels) {
    device_.max_texels = max_texels;
    TestRig rig = TestRig::with_edge_rays(device_, torn_cloths(300), kSide_px);
    return errors(rig, {0.02, 0.01, 0}, 0.003);
  };
  const Errors all = errors_with(1'000'000), small = errors_with(100'000);
  EXPECT_LT(all.exact, 0.5 * all.line);
  EXPECT_GT(small.exact, 2 * all.exact);
  EXPECT_LT(small.exact, small.line);
}

/// If an eye has more edges than fit into its list, none has rays: the order of invocations would choose.
TEST_F(EdgeRaysIn, AMaskOfNoiseHaveTheLine) {
  constexpr std::uint32_t kLarge_px = 512;
  TestRig rig = TestRig::with_edge_rays(device_, still_room(), kLarge_px);
  const auto head_at = [&](double times) { return moved(rig.head(), 0.003 * times, {0.01 * times, 0, 0}); };
  std::vector<Mask> masks = masks_of(rig, head_at);
  const StereoView now = rig.eyes(head_at(0));
  EXPECT_FALSE(same_visibility(rig.show(now, traced(masks), kExact), rig.show(now, traced(masks), kLine)));
  std::mt19937 random(5);
  for (EyeMask& bits : masks[0].bits)
    for (std::uint32_t y = 0; y < bits.size().height; ++y)
      for (std::uint32_t x = 0; x < bits.size().width; ++x)
        bits.set_word(x, y, 0, static_cast<std::uint32_t>(random()) & bits.layout().used_bits(0));
  const Shown exact = rig.show(now, traced(masks), kExact), line = rig.show(now, traced(masks), kLine);
  std::size_t different = 0, all = 0;
  for (const Side side : kSides) {
    const std::vector<std::uint8_t>&a = exact.reports[index_of(side)].visibility,
          &b = line.reports[index_of(side)].visibility;
    for (std::size_t i = 0; i < a.size(); ++i) different += a[i] != b[i];
    all += a.size();
  }
  std::printf("of a mask of noise %.2f %% differ from the line\n",
              100 * static_cast<double>(different) / static_cast<double>(all));
  EXPECT_LT(different, all / 50) << "where a thin line is near, the line is taken, too";
}

TEST_F(EdgeRaysIn, AWarmedUpRendererMakeNoPipelineInAFrame) {
  TestRig rig = TestRig::with_edge_rays(device_, bundled("box_over_plane.gltf"), kSide_px);
  const auto head_at = [&](double times) { return moved(rig.head(), 0.003 * times, {0.02 * times, 0, 0}); };
  const std::vector<Mask> masks = masks_of(rig, head_at);
  for (const std::function<void()>& step :
       rig.renderer().compile_steps(kExact, PixelReport::On, Changes::Never))
    step();
  const std::size_t pipelines = rig.renderer().counters().pipelines;
  static_cast<void>(rig.show(rig.eyes(head_at(0)), traced(masks), kExact));
  EXPECT_EQ(rig.renderer().counters().pipelines, pipelines);
}

}  // namespace
}  // namespace farshade
