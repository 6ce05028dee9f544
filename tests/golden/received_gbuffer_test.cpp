/// A G-buffer that one renderer reads and another receives gives the same picture, bit for bit.
#include <bit>
#include <limits>

#include "stereo/frame/tiles.h"
#include "stereo/raster/mesh_streams.h"
#include "tests/golden/test_rig.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

constexpr std::uint32_t kReceivedSide_px = 160;
constexpr RendererLimits kLimits{.size = {kReceivedSide_px, kReceivedSide_px},
                                 .traced_size = {kReceivedSide_px + 32, kReceivedSide_px + 32},
                                 .depth_frames = 2};

class ReceivedGBuffer : public OnLavapipe {
 protected:
  /// A mask that was traced for `views`, with all tiles known.
  static Mask traced(const Scene& scene, const StereoView& views) {
    Tracer tracer = Tracer::create(scene).value();
    ShadowFrame frame;
    tracer.trace({{.frame = {}, .display_time = {}, .scene_time = {}, .views = views}}, frame);
    const ReceivedTiles all(TileGrid{views[0].size}.count(), all_planes_received(frame.masks[0].layout()));
    return {FrameId{}, Time{}, views, std::move(frame.masks), {all, all}};
  }

  static ShownFrame shown(const StereoView& views, const SceneState& state,
                          std::span<const TracedMask> masks) {
    return {.views = views, .state = state, .masks = masks, .reprojection = {.lookup = Lookup::Direct}};
  }

  /// Another renderer with its own plan, which receives only the planes.
  void expect_same_picture(const Scene& scene, const DrawPlan& sender_plan, const DrawPlan& receiver_plan) {
    const auto sender_owner = make_renderer(device_, scene, sender_plan, kLimits);
    const auto receiver_owner = make_renderer(device_, scene, receiver_plan, kLimits);
    Renderer &sender = *sender_owner, &receiver = *receiver_owner;
    const SceneState state = state_at(scene, Time{});
    const StereoView views = eyes_of(head_at_camera(scene), kReceivedSide_px);
    const Mask mask = traced(scene, views);
    const std::vector<TracedMask> masks{mask.traced_mask()};
    sender.draw(shown(views, state, masks));
    GBufferPlanes planes;
    sender.read_gbuffer(planes);
    const auto drawn = sender.read_shown();
    receiver.draw_received(planes, shown(views, state, masks));
    EXPECT_EQ(receiver.read_shown(), drawn);
    EXPECT_EQ(receiver.read_distance(), sender.read_distance());
    GBufferPlanes again;
    receiver.read_gbuffer(again);
    EXPECT_EQ(again, planes);
    EXPECT_LT(std::ranges::count(drawn[0].pixels, drawn[0].pixels[0]), std::ssize(drawn[0].pixels) / 2);
  }
};

DrawPlan whole_plan(const Scene& scene) {
  return plan_for(scene, {.all_lights = true}).draw;
}

TEST_F(ReceivedGBuffer, GivesTheSamePictureBitForBit) {
  for (const char* name : {"room.glb", "box_over_plane.gltf"}) {
    SCOPED_TRACE(name);
    const Scene scene = bundled(name);
    expect_same_picture(scene, whole_plan(scene), whole_plan(scene));
  }
}

/// If masks are not reprojected, the images have other words.
TEST_F(ReceivedGBuffer, GivesTheSamePictureBetweenPlans) {
  const Scene scene = bundled("room.glb");
  const DrawPlan direct = plan_for(scene, {.reprojects = false, .all_lights = true}).draw;
  expect_same_picture(scene, direct, whole_plan(scene));
  expect_same_picture(scene, whole_plan(scene), direct);
}

/// One pixel, or a part of a report, is the same as in the whole.
TEST_F(ReceivedGBuffer, ASinglePixelIsThatOfTheWhole) {
  for (const char* name : {"room.glb", "box_over_plane.gltf"})
    for (const bool reprojects : {true, false}) {
      SCOPED_TRACE(name);
      const Scene scene = bundled(name);
      const DrawPlan plan = plan_for(scene, {.reprojects = reprojects, .all_lights = true}).draw;
      const std::unique_ptr<Renderer> renderer_owner = make_renderer(device_, scene, plan, kLimits);
      Renderer& renderer = *renderer_owner;
      const SceneState state = state_at(scene, Time{});
      const StereoView views = eyes_of(head_at_camera(scene), kReceivedSide_px);
      const Mask mask = traced(scene, views);
      const std::vector<TracedMask> masks{mask.traced_mask()};
      ShownFrame frame = shown(views, state, masks);
      frame.report = PixelReport::On;
      renderer.draw(frame);
      GBufferPlanes planes;
      renderer.read_gbuffer(planes);
      const PerEye<Image<float>> distance = renderer.read_distance();
      const bool moves = reprojects && plan.anything_moves();
      for (const Side side : kSides) {
        const std::size_t eye = index_of(side);
        const ShownReport whole = renderer.report(side);
        for (const glm::uvec2 at : {glm::uvec2{0, 0}, {80, 80}, {31, 150}, {159, 159}, {159, 7}}) {
          const ShownSurface surface = renderer.read_surface(side, at);
          EXPECT_EQ(surface.distance_m, distance[eye].at(at.x, at.y));
          EXPECT_EQ(surface.instance.has_value(), moves && surface.distance_m > 0);
          const std::size_t i = std::size_t{at.y} * kReceivedSide_px + at.x;
          if (surface.distance_m > 0) {
            EXPECT_NEAR(glm::length(surface.normal), 1, 1e-6);
            const glm::i16vec2 packed = octahedral(surface.normal);
            const auto word = static_cast<std::uint32_t>(static_cast<std::uint16_t>(packed.y)) << 16 |
                              static_cast<std::uint16_t>(packed.x);
            EXPECT_EQ(word, planes.normal[eye].words[i]);
          }
          const ShownReport one = renderer.report(side, {at.x, at.y, at.x + 1, at.y + 1});
          EXPECT_EQ(one.sources, std::vector{whole.sources[i]});
          EXPECT_EQ(one.positions, std::vector{whole.positions[i]});
          EXPECT_EQ(one.rays, std::vector{whole.rays[i]});
          EXPECT_EQ(one.mask.word(0, 0), whole.mask.word(at.x, at.y));
          EXPECT_EQ(one.visibility[0], whole.visibility[i * whole.mask.lights()]);
        }
      }
    }
}

TEST_F(ReceivedGBuffer, MissingTilesAreBackground) {
  const Scene scene = bundled("box_over_plane.gltf");
  const std::unique_ptr<Renderer> renderer_owner = make_renderer(device_, scene, kLimits);
  Renderer& renderer = *renderer_owner;
  const SceneState state = state_at(scene, Time{});
  const StereoView views = eyes_of(head_at_camera(scene), kReceivedSide_px);
  const Mask mask = traced(scene, views);
  const std::vector<TracedMask> masks{mask.traced_mask()};
  renderer.draw(shown(views, state, masks));
  const auto drawn = renderer.read_shown();
  GBufferPlanes planes;
  renderer.read_gbuffer(planes);
  const float strange[] = {0.0f, -0.5f, 1.5f, std::numeric_limits<float>::quiet_NaN(),
                           std::numeric_limits<float>::infinity()};
  for (std::uint32_t x = 0; x < kReceivedSide_px; ++x)
    planes.depth[0].words[100 * kReceivedSide_px + x] = std::bit_cast<std::uint32_t>(strange[x % 5]);
  renderer.draw_received(planes, shown(views, state, masks));
  const auto received = renderer.read_shown();
  EXPECT_EQ(received[1], drawn[1]);
  for (std::uint32_t y = 0; y < kReceivedSide_px; ++y)
    for (std::uint32_t x = 0; x < kReceivedSide_px; ++x)
      ASSERT_EQ(received[0].at(x, y), y == 100 ? Rgb8(0) : drawn[0].at(x, y)) << x << ", " << y;
}

/// Neither the sender nor the receiver allocates buffers before the first use.
TEST_F(ReceivedGBuffer, TakesNoMemoryBeforeItIsUsed) {
  const Scene scene = bundled("box_over_plane.gltf");
  const std::unique_ptr<Renderer> renderer_owner = make_renderer(device_, scene, kLimits);
  Renderer& renderer = *renderer_owner;
  const SceneState state = state_at(scene, Time{});
  const StereoView views = eyes_of(head_at_camera(scene), kReceivedSide_px);
  renderer.draw(shown(views, state, {}));
  const auto held = [&](gpu::Use use) { return renderer.counters().memory.now[use]; };
  EXPECT_EQ(held(gpu::Use::ReadBack), 0u);
  GBufferPlanes planes;
  renderer.read_gbuffer(planes);
  const std::uint64_t once = held(gpu::Use::ReadBack);
  EXPECT_GT(once, 0u);
  std::vector<std::uint64_t> allocations, uploads;
  for (int frame = 0; frame < 4; ++frame) {
    renderer.draw_received(planes, shown(views, state, {}));
    static_cast<void>(renderer.finish());
    renderer.read_gbuffer(planes);
    allocations.push_back(renderer.counters().memory.allocations);
    uploads.push_back(held(gpu::Use::Uploads));
  }
  EXPECT_EQ(held(gpu::Use::ReadBack), once);
  EXPECT_EQ(allocations, std::vector(4, allocations[0])) << "frames use the same memory";
  EXPECT_EQ(uploads, std::vector(4, uploads[0]));
}

}  // namespace
}  // namespace farshade
