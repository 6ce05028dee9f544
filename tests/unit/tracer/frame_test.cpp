// The tracer's frames: mask words, reuse of buffers, ray counts, and moving meshes and lights.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <random>
#include <thread>

#include "stereo/tracer/tile_stages.h"
#include "tests/oracle/agreement.h"
#include "tests/oracle/random_scenes.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

constexpr double kMostInBand = 0.03;
const View kLeft = look({0.1, 3.0, 2.9}, {0.03, 0.0, -0.1}, 64);
const View kRight = look({0.2, 3.0, 2.9}, {0.03, 0.0, -0.1}, 64);

SceneBuilder lit_floor(int lights) {
  SceneBuilder build;
  build.add(quad({0, 0, 0}, {4, 0, 0}, {0, 0, -4}));
  build.add(box({0, 1, 0}, {0.5f, 0.5f, 0.5f}));
  for (int i = 0; i < lights; ++i) build.point_light({-2.0 + 0.1 * i, 2.5, 0.03 * i - 0.4});
  return build;
}

TEST(TracerFrame, CarriesItsRequest) {
  const Scene scene = lit_floor(1).build();
  auto tracer = Tracer::create(scene).value();
  ShadowFrame frame;
  tracer.trace(request_for({kLeft, kRight}, Time{}, FrameId{7}), frame);
  EXPECT_EQ(frame.frame, FrameId{7});
  EXPECT_EQ(frame.views[0], kLeft);
  EXPECT_EQ(frame.views[1], kRight);
  EXPECT_EQ(frame.light_set_revision, state_at(scene, Time{}).light_set.revision);
  EXPECT_NE(frame.masks[0], frame.masks[1]);
}

TEST(TracerFrame, WordsOfEveryWidthAgreeWithTheOracle) {
  for (const int lights : {1, 8, 9, 16, 17, 32, 33, 40, 64}) {
    SCOPED_TRACE(lights);
    const oracle::Agreement sum =
        expect_agrees(lit_floor(lights).build(), {kLeft, kRight}, Time{}, kMostInBand);
    EXPECT_GT(sum.lit, 0u);
  }
}

TEST(TracerFrame, BitsStayWithTheirLights) {
  const Scene scene = lit_floor(40).build();
  const ShadowFrame all = traced(scene, {kLeft, kRight});
  for (const std::uint32_t light : {0u, 31u, 32u, 39u}) {
    Scene one = scene;
    one.lights = {scene.lights[light]};
    const ShadowFrame alone = traced(one, {kLeft, kRight});
    for (std::uint32_t y = 0; y < 64; ++y)
      for (std::uint32_t x = 0; x < 64; ++x)
        ASSERT_EQ(all.masks[1].lit(x, y, light), alone.masks[1].lit(x, y, 0))
            << light << " at " << x << ", " << y;
  }
}

TEST(TracerFrame, ATraceThatIsGivenUpEndsAtTheNextGroupsAndHarmsNoLaterOne) {
  const Scene scene = lit_floor(3).build();
  auto tracer = Tracer::create(scene).value();
  const FrameRequest request =
      request_for({look({0.1, 3.0, 2.9}, {0.03, 0.0, -0.1}, 512), look({0.2, 3.0, 2.9}, {}, 512)});
  ShadowFrame whole, frame;
  tracer.trace(request, whole);
  frame = whole;
  for (std::byte& byte : frame.masks[1].bytes())
    byte = std::byte{0xff};  // no trace of three lights writes that
  std::atomic<int> requested = 0;
  EXPECT_THROW(tracer.trace(request, frame, [&] { return ++requested > 100; }), TraceGivenUp);
  EXPECT_GT(std::ranges::count(frame.masks[1].bytes(), std::byte{0xff}), 512 * 512 / 4) << "it goes on";
  EXPECT_LT(requested, 100 + 2 * static_cast<int>(std::thread::hardware_concurrency()) + 1)
      << "of 2,048 groups; a core may ask while another one is told";
  tracer.trace(request, frame, [] { return false; });
  EXPECT_EQ(frame.masks, whole.masks);
}

TEST(TracerFrame, ReusesBuffersAndOverwritesAllOfThem) {
  const Scene scene = lit_floor(3).build();
  auto tracer = Tracer::create(scene).value();
  ShadowFrame frame;
  tracer.trace(request_for({kLeft, kRight}), frame);
  const ShadowFrame first = frame;
  const std::byte* const buffer = frame.masks[0].bytes().data();
  for (std::byte& byte : frame.masks[0].bytes()) byte = std::byte{0xff};
  tracer.trace(request_for({kLeft, kRight}), frame);
  EXPECT_EQ(frame.masks[0], first.masks[0]);
  EXPECT_EQ(frame.masks[0].bytes().data(), buffer);
}

TEST(TracerFrame, FollowsAChangeOfSize) {
  const Scene scene = lit_floor(2).build();
  auto tracer = Tracer::create(scene).value();
  ShadowFrame frame;
  for (const Extent size : {Extent{64, 64}, Extent{1, 1}, Extent{17, 33}, Extent{15, 48}}) {
    StereoView views{kLeft, kRight};
    views[0].size = size;
    tracer.trace(request_for(views), frame);
    EXPECT_EQ(frame.masks[0].size(), size);
    const auto truth = oracle::trace(scene, state_at(scene, Time{}), views[0]);
    EXPECT_EQ(oracle::compare(frame.masks[0], truth).wrong, 0u);
  }
}

TEST(TracerFrame, CoincidingViewsAreTracedOnce) {
  const Scene scene = lit_floor(2).build();
  auto tracer = Tracer::create(scene).value();
  ShadowFrame twice, once;
  const TraceStats both = tracer.trace(request_for({kLeft, kRight}), twice);
  const TraceStats same = tracer.trace(request_for({kLeft, kLeft}), once);
  EXPECT_EQ(once.masks[0], twice.masks[0]);
  EXPECT_EQ(once.masks[1], twice.masks[0]);
  EXPECT_EQ(both.primary_rays, 2u * 64 * 64);
  EXPECT_EQ(same.primary_rays, 64u * 64);
}

TEST(TracerFrame, CountsOnlyRaysThatMatter) {
  SceneBuilder build;
  build.add(quad({0, 0, 0}, {4, 0, 0}, {0, 0, -4}));
  build.point_light({0, 2, 0});
  build.point_light({0, -2, 0});                 // below
  build.point_light({0, 2, 0}, 1.0f);            // out of range
  build.spot_light({0, 2, 0}, {0, 1, 0}, 0.5f);  // shines away
  const Scene scene = build.build();
  auto tracer = Tracer::create(scene).value();
  ShadowFrame frame;
  const TraceStats stats = tracer.trace(request_for({kLeft, kLeft}), frame);
  std::uint64_t covered = 0;
  for (const std::uint8_t pixel : oracle::trace(scene, state_at(scene, Time{}), kLeft).covered)
    covered += pixel;
  EXPECT_EQ(stats.full_shadow_rays, covered * 4 * 2);
  EXPECT_EQ(stats.shadow_rays, covered);
  EXPECT_EQ(stats.turned_away, covered);
  EXPECT_EQ(stats.out_of_range, covered);
  EXPECT_EQ(stats.out_of_cone, covered);
}

TEST(TracerFrame, NoRayWhereEitherNormalTurnsAway) {
  Mesh leaning = quad({0, 0, 0}, {4, 0, 0}, {0, 0, -4});
  for (glm::vec3& normal : leaning.normals) normal = glm::normalize(glm::vec3(1.0f, 0.2f, 0.0f));
  SceneBuilder build;
  build.add(leaning);
  build.directional_light({-1.0, 0.1, 0.0});  // from behind the triangle, on the side of its shading normal
  build.directional_light({1.0, -1.0, 0.0});  // the opposite case
  const Scene scene = build.build();
  auto tracer = Tracer::create(scene).value();
  ShadowFrame frame;
  const TraceStats stats = tracer.trace(request_for({kLeft, kRight}), frame);
  EXPECT_GT(stats.full_shadow_rays, 0u);
  EXPECT_EQ(stats.shadow_rays, 0u);
}

TEST(TracerFrame, WithoutLightsNothingIsTraced) {
  const Scene scene = lit_floor(0).build();
  auto tracer = Tracer::create(scene).value();
  ShadowFrame frame;
  const TraceStats stats = tracer.trace(request_for({kLeft, kRight}), frame);
  EXPECT_EQ(stats.primary_rays, 0u);
  EXPECT_EQ(frame.masks[0], EyeMask(kLeft.size, 0));
}

/// The words of every tile of kLeft, traced in packets of K.
template <int K>
std::vector<std::uint32_t> words_by(const Scene& scene) {
  const SceneState state = state_at(scene, time_from_ns(250'000'000));
  const SurfaceModel model(scene, state, plan_for(scene).trace);
  const RayScene rays = RayScene::create(model).value();
  std::vector<std::uint32_t> all;
  const TileGrid grid{kLeft.size};
  for (std::uint32_t tile = 0; tile < grid.count(); ++tile) {
    TileSurface surface;
    see_group<K>(rays, model, rays_of(kLeft, model.anchor_from_stage()), group_of(grid.rect(tile), 1),
                 surface);
    std::uint32_t words[kTilePixels]{};
    for (std::uint32_t i = 0; i < state.light_set.lights.size(); ++i)
      shadow_group<K>(surface, kAllBlocks, shadow_light(state.light_set.lights[i], model), 1u << i, words,
                      [&](const Lanes<K>& lanes, RayPacket<K>& packet) { rays.occluded(lanes, packet); });
    all.insert(all.end(), std::begin(words), std::end(words));
  }
  return all;
}

TEST(TracerFrame, PacketWidthChangesNothing) {
  SceneBuilder build = lit_floor(3);
  build.move(build.add(box({-1, 0.6f, 0.5f}, {0.3f, 0.2f, 0.3f})), {0.5, 0, 0});
  const Scene scene = build.build();
  const std::vector<std::uint32_t> wide = words_by<16>(scene);
  EXPECT_EQ(words_by<8>(scene), wide);
  EXPECT_EQ(words_by<4>(scene), wide);
}

TEST(TracerFrame, EmptySceneIsDark) {
  SceneBuilder build;
  build.point_light({0, 1, 0});
  const ShadowFrame frame = traced(build.build(), {kLeft, kRight});
  EXPECT_EQ(frame.masks[0], EyeMask(kLeft.size, 1));
}

TEST(TracerFrame, MovingMeshesAreWhereTheTimeSays) {
  SceneBuilder build = lit_floor(2);
  const auto mover = build.add(box({-1, 0.6f, 0.5f}, {0.3f, 0.2f, 0.3f}), 0, scaled({1, 2, -0.5}));
  build.move(mover, {1.5, 0.3, 0.2});
  const Scene scene = build.build();
  auto tracer = Tracer::create(scene).value();
  ShadowFrame frame, first;
  for (const std::int64_t ms : {0, 250, 900, 0}) {
    SCOPED_TRACE(ms);
    const Time time = time_from_ns(ms * 1'000'000);
    tracer.trace(request_for({kLeft, kRight}, time), frame);
    for (const Side side : kSides) {
      const auto truth = oracle::trace(scene, state_at(scene, time), frame.views[index_of(side)]);
      EXPECT_EQ(oracle::compare(frame.masks[index_of(side)], truth).wrong, 0u);
    }
    if (first.masks[0].size().pixels() == 0)
      first = frame;
    else
      EXPECT_EQ(frame.masks[0] == first.masks[0], ms == 0);
  }
}

/// Bending 20,000 triangles and their hierarchy takes milliseconds, finding that nothing is to be done does
/// not.
TEST(TracerFrame, ReportsTheTimeInWhichItBringsTheSceneToTheRequest) {
  std::mt19937 random(1);
  const Scene scene = bending_figures(random, 20'000);
  auto tracer = Tracer::create(scene).value();
  ShadowFrame frame;
  Duration moved = Duration::max(), stood = Duration::max();
  for (std::int64_t i = 1; i <= 4; ++i) {
    const FrameRequest request = request_for({kLeft, kRight}, time_from_ns(i * 100'000'000));
    const Stopwatch watch;
    const TraceStats stats = tracer.trace(request, frame);
    EXPECT_LE(stats.update + stats.primary + stats.shadow, watch.elapsed());
    moved = std::min(moved, stats.update);
    stood = std::min(stood, tracer.trace(request, frame).update);
  }
  EXPECT_GT(moved, 5 * stood);
}

TEST(TracerFrame, MovingLightMovesItsBitOnly) {
  SceneBuilder build = lit_floor(1);
  build.move(build.point_light({1.0, 2.0, 0.5}), {-1.0, 0, 0});
  const Scene scene = build.build();
  expect_agrees(scene, {kLeft, kRight}, time_from_ns(700'000'000), kMostInBand);
  const ShadowFrame start = traced(scene, kLeft, Time{}),
                    later = traced(scene, kLeft, time_from_ns(700'000'000));
  int same = 0, changed = 0;
  for (std::uint32_t y = 0; y < 64; ++y)
    for (std::uint32_t x = 0; x < 64; ++x) {
      EXPECT_EQ(start.masks[0].lit(x, y, 0), later.masks[0].lit(x, y, 0));
      (start.masks[0].lit(x, y, 1) == later.masks[0].lit(x, y, 1) ? same : changed)++;
    }
  EXPECT_GT(changed, 50);
  EXPECT_GT(same, 1000);
}

TEST(TracerFrame, OnlyMovingMeshesAreTraced) {
  SceneBuilder build;
  build.move(build.add(quad({0, 0, 0}, {4, 0, 0}, {0, 0, -4})), {0.2, 0, 0});
  build.point_light({0.5, 2, 0.2});
  const oracle::Agreement sum =
      expect_agrees(build.build(), {kLeft, kRight}, time_from_ns(500'000'000), kMostInBand);
  EXPECT_GT(sum.lit, sum.pixel_lights / 2);
}

TEST(TracerFrame, FlattenedMovingMeshStillCasts) {
  SceneBuilder build = lit_floor(1);
  NodeTransform flat = scaled({1, 0, 1});
  flat.translation = {0, 2, 0};
  build.move(build.add(box({0, 0, 0}, {0.7f, 0.2f, 0.7f}), 0, flat), {0.1, 0, 0});
  expect_agrees(build.build(), {kLeft, kRight}, time_from_ns(500'000'000), kMostInBand);
}

TEST(TracerFrame, SingularInstanceIsNotThere) {
  SceneBuilder build = lit_floor(1);
  const Scene without = build.build();
  NodeTransform singular;
  singular.matrix = glm::dmat4(0.0);
  (*singular.matrix)[0][0] = (*singular.matrix)[2][2] = (*singular.matrix)[3][3] = 1;
  build.add(box({0, 2, 0}, {3, 0.1f, 3}), 0, singular);
  EXPECT_EQ(traced(build.build(), kLeft).masks[0], traced(without, kLeft).masks[0]);
}

TEST(TracerFrame, AHiddenInstanceIsNotThereUntilItIsShown) {
  SceneBuilder build = lit_floor(1);
  const Scene without = build.build();
  const std::uint32_t node = build.add(box({0, 2, 0}, {1, 0.1f, 1}));
  const Scene always = build.build();
  Scene scene = always;
  scene.channels = {{.node = node,
                     .path = Path::Visible,
                     .interpolation = Interpolation::Step,
                     .keys_s = {0, 1, 2},
                     .values = {{}, {1, 0, 0, 0}, {}}}};
  scene.animation_length_s = 3;
  scene.instances.back().shown_with = node;
  auto tracer = Tracer::create(scene).value();
  ShadowFrame frame;
  for (const double seconds : {0.5, 1.5, 2.5, 4.5}) {
    tracer.trace(request_for({kLeft, kRight}, Time(duration_from_ms(seconds * 1e3))), frame);
    const bool shown = seconds == 1.5 || seconds == 4.5;
    EXPECT_EQ(frame.masks[0], traced(shown ? always : without, {kLeft, kRight}).masks[0]) << seconds;
  }
}

}  // namespace
}  // namespace farshade
