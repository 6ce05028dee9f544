/// Shadow maps that are kept while nothing moves in them: the same pictures as from maps that are drawn in
/// every frame, with less work and a bounded amount of memory.
#include "stereo/shadow_maps/shadow_map_views.h"
#include "tests/golden/test_rig.h"
#include "tests/oracle/scene_builder.h"

namespace farshade {
namespace {

constexpr std::uint32_t kEye_px = 128;
constexpr ShadowMapSettings kWhenMoved{.side_px = 256}, kAlways{.side_px = 256, .redraw = Redraw::Always};

/// A renderer that shows a scene with shadow maps.
class MapRenderer {
 public:
  MapRenderer(const gpu::Device& device, const Scene& scene, const ShadowMapSettings& settings)
      : renderer_(make_renderer(device, scene,
                                plan_for(scene, {.reprojects = false, .all_lights = true}).draw,
                                {{kEye_px, kEye_px}, {kEye_px, kEye_px}, 1})),
        settings_(settings) {}

  PerEye<Image<Rgb8>> show(const Rigid<Stage, Head>& head, const SceneState& state) {
    renderer_->draw({.views = eyes_of(head, kEye_px),
                     .state = state,
                     .masks = {},
                     .reprojection = {},
                     .shadow_maps = &settings_});
    return renderer_->read_shown();
  }

  [[nodiscard]] DrawCounters counters() const { return renderer_->counters(); }

 private:
  std::unique_ptr<Renderer> renderer_;
  ShadowMapSettings settings_;
};

enum Lights : std::uint32_t { kSpot, kFixedPoint, kMovingPoint, kSun };

/// Everything that maps depend on: casters that move, turn and stand, one of them with holes, and lights of
/// every kind. The spot's layer shares a pair with a face of the cube of the fixed light.
Scene busy_scene() {
  SceneBuilder builder;
  builder.add(quad({0, 0, 0}, {0, 0, 4}, {4, 0, 0}));
  builder.add(box({0.8f, 0.5f, -0.5f}, {0.2f, 0.5f, 0.2f}));
  builder.move(builder.add(box({-1.2f, 0.6f, 0}, {0.3f, 0.2f, 0.4f})), {2, 0, 0});
  builder.turn(builder.add(box({0.3f, 1.2f, 0.5f}, {0.5f, 0.05f, 0.1f})), 2.5);
  Texture sieve{.image = Image<Rgba8>({4, 4})};
  for (std::size_t i = 0; i < sieve.image.pixels.size(); ++i)
    sieve.image.pixels[i] = Rgba8(200, 200, 200, (i + i / 4) % 2 == 0 ? 0 : 255);
  Material masked;
  masked.double_sided = true;
  masked.alpha_cutoff = 0.5f;
  masked.texture = builder.texture(sieve);
  builder.move(builder.add(quad({0, 0.9f, 0.8f}, {0, 0, 0.4f}, {0.4f, 0, 0}), builder.material(masked)),
               {-1, 0.3, 0});
  builder.spot_light({1.5, 2.5, 0.5}, {-0.5, -1, -0.1}, 0.6f);
  builder.point_light({-0.3, 2.2, 0.4});
  builder.move(builder.point_light({0.5, 2.6, -1}), {-1, 0, 0.5});
  builder.directional_light({-0.5, -1, -0.2});
  return builder.build();
}

/// What one frame shows.
struct BusyFrame {
  int time_ms;
  LightChanges changes;
};

/// Movement, pauses, and every kind of change by the viewer: lights that are dragged, switched off while
/// something moves or stands, and placed back.
std::vector<BusyFrame> busy_frames() {
  std::vector<BusyFrame> frames;
  LightChanges changes;
  const auto show = [&](std::initializer_list<int> times_ms) {
    for (const int time_ms : times_ms) frames.push_back({time_ms, changes});
  };
  const auto sun = [](double x) { return LightPose{{}, {glm::normalize(glm::dvec3(x, -1, 0))}}; };
  show({0, 0, 100, 200, 200});
  change(changes, kSun, true, sun(0.1));
  show({300});
  change(changes, kSun, true, sun(0.2));
  show({300, 400});
  change(changes, kFixedPoint, false, std::nullopt);
  show({400, 500, 650});
  change(changes, kSpot, true, LightPose{{{1.2, 2.5, 0.2}}, {glm::normalize(glm::dvec3(-0.4, -1, 0))}});
  show({650});
  change(changes, kFixedPoint, true, std::nullopt);
  show({650, 700});
  change(changes, kSpot, true, std::nullopt);
  change(changes, kSun, false, std::nullopt);
  show({700});
  change(changes, kSun, true, sun(0.2));
  show({700, 50});
  return frames;
}

using KeptShadowMaps = OnLavapipe;

TEST_F(KeptShadowMaps, GiveThePicturesOfMapsThatAreDrawnInEveryFrame) {
  const Scene scene = busy_scene();
  MapRenderer kept(device_, scene, kWhenMoved), always(device_, scene, kAlways);
  const Rigid<Stage, Head> head = head_looking({-1.5, 2.2, 2.5}, {0, 0.3, 0});
  PerEye<Image<Rgb8>> before;
  int frame = 0, changed = 0;
  std::uint64_t drawn = 0, restored = 0, drawn_always = 0;
  for (const BusyFrame& shown : busy_frames()) {
    const SceneState state = state_at(scene, Time(std::chrono::milliseconds(shown.time_ms)), shown.changes);
    const PerEye<Image<Rgb8>> expected = always.show(head, state), found = kept.show(head, state);
    for (std::size_t eye = 0; eye < kEyes; ++eye)
      EXPECT_TRUE(found[eye].pixels == expected[eye].pixels) << "frame " << frame << ", eye " << eye;
    changed += expected[0].pixels != before[0].pixels;
    before = expected;
    drawn += kept.counters().map_layers_drawn;
    restored += kept.counters().map_layers_restored;
    drawn_always += always.counters().map_layers_drawn;
    EXPECT_EQ(always.counters().map_layers_restored, 0u);
    ++frame;
  }
  EXPECT_EQ(frame, 17);
  EXPECT_GE(changed, 12) << "the frames show different shadows";
  EXPECT_GT(restored, 20u);
  EXPECT_LT(drawn, drawn_always / 2);
}

TEST_F(KeptShadowMaps, AreRestoredWithoutTheVerticesOfFixedInstances) {
  SceneBuilder builder;
  builder.add(quad({0, 0, 0}, {0, 0, 4}, {4, 0, 0}));
  builder.move(builder.add(box({-0.5f, 0.8f, 0}, {0.3f, 0.2f, 0.4f})), {1, 0, 0});
  builder.directional_light({-0.5, -1, -0.2});
  const Scene scene = builder.build();
  MapRenderer renderer(device_, scene, kWhenMoved);
  const Rigid<Stage, Head> head = head_looking({-1.5, 2, 2.5}, {0, 0.2, 0});
  const auto bytes_read = [&](int time_ms) {
    renderer.show(head, state_at(scene, Time(std::chrono::milliseconds(time_ms))));
    return renderer.counters().vertex_bytes_read;
  };
  const std::uint64_t first = bytes_read(0), none = bytes_read(0), restored = bytes_read(100);
  const auto bytes_of = [](const Mesh& mesh) {
    return mesh.positions.size() * sizeof(glm::vec3) + mesh.triangles.size() * 3 * sizeof(std::uint16_t);
  };
  const std::uint64_t ground = bytes_of(scene.meshes[0]), moving = bytes_of(scene.meshes[1]);
  EXPECT_EQ(first - none, ground + moving);
  EXPECT_EQ(restored - none, moving);
}

TEST_F(KeptShadowMaps, TakeMemoryOnlyIfALightCanStandStillWhileSomethingMoves) {
  const auto held = [&](const Scene& scene, const ShadowMapSettings& settings) {
    MapRenderer renderer(device_, scene, settings);
    renderer.show(head_looking({-1.5, 2, 2.5}, {0, 0.2, 0}), state_at(scene, Time{}));
    const std::uint64_t bytes = renderer.counters().memory.now[gpu::Use::ShadowMaps];
    EXPECT_NEAR(static_cast<double>(bytes), static_cast<double>(shadow_map_bytes(scene, settings).value()),
                64 << 10);
    return bytes >> 18;  // maps of 256 x 256 texels
  };
  EXPECT_EQ(held(busy_scene(), kAlways), 14u);
  EXPECT_EQ(held(busy_scene(), kWhenMoved), 14u + 10u) << "all but two pairs of the light that moves";
  Scene still = busy_scene();
  still.channels.clear();
  for (Node& node : still.nodes) node.moving = false;
  EXPECT_EQ(held(still, kWhenMoved), 14u);
}

}  // namespace
}  // namespace farshade
