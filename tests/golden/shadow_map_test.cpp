/// Compares shadow maps with the full trace: the error of visibilities for every kind of light. Maps are
/// redrawn only when they must be.
#include <array>
#include <cmath>

#include "stereo/frame/tiles.h"
#include "stereo/image/difference.h"
#include "tests/golden/test_rig.h"
#include "tests/oracle/scene_builder.h"
#include "vr_client/report/measure.h"

namespace farshade {
namespace {

constexpr std::uint32_t kSide_px = 192;
constexpr Extent kSize{kSide_px, kSide_px};

/// Errors against the full trace; the worse of the two eyes.
struct Wrong {
  double mask_error = 0;
  double dark = 0,
         lit =
             0;  ///< shares of pixel-lights: traced as lit but shown as less; traced as dark but shown as lit
  double shadowed = 0;  ///< share that was traced as dark
};

/// A scene that is shown with masks of a full trace or with shadow maps.
class ShadowMapRig {
 public:
  ShadowMapRig(const gpu::Device& device, Scene scene)
      : scene_(std::move(scene)),
        tracer_(Tracer::create_reference(scene_).value()),
        renderer_(make_renderer(device, scene_,
                                plan_for(scene_, {.reprojects = false, .all_lights = true}).draw,
                                {kSize, kSize, 1})) {}

  DrawTimes show(const Rigid<Stage, Head>& head, const ShadowMapSettings& settings) {
    renderer_->draw({.views = eyes_of(head, kSide_px),
                     .state = state_,
                     .masks = {},
                     .reprojection = {},
                     .report = PixelReport::On,
                     .shadow_maps = &settings});
    return renderer_->finish();
  }

  void show_traced(const Rigid<Stage, Head>& head) {
    const StereoView views = eyes_of(head, kSide_px);
    const PerEye<EyeMask> bits = traced(views);
    const ReceivedTiles all(TileGrid{kSize}.count(), all_planes_received(bits[0].layout()));
    const PerEye<ReceivedTiles> known{all, all};
    const std::vector<TracedMask> masks{{.frame = FrameId{++frames_},
                                         .display_time = {},
                                         .scene_time = state_.scene_time,
                                         .views = views,
                                         .masks = bits,
                                         .received_tiles = known}};
    renderer_->draw(
        {.views = views, .state = state_, .masks = masks, .reprojection = {}, .report = PixelReport::On});
  }

  /// The errors of the picture that was shown last, from `head`.
  [[nodiscard]] Wrong wrong(const Rigid<Stage, Head>& head) {
    const PerEye<EyeMask> truth = traced(eyes_of(head, kSide_px));
    Wrong worst;
    for (const Side side : kSides) {
      const Wrong eye = wrong(renderer_->report(side), truth[index_of(side)]);
      worst.mask_error = std::max(worst.mask_error, eye.mask_error);
      worst.dark = std::max(worst.dark, eye.dark);
      worst.lit = std::max(worst.lit, eye.lit);
      worst.shadowed = eye.shadowed;
    }
    return worst;
  }

  Wrong show_and_judge(const Rigid<Stage, Head>& head, const ShadowMapSettings& settings) {
    show(head, settings);
    return wrong(head);
  }

  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] Renderer& renderer() { return *renderer_; }
  void set(Time scene_time, const LightChanges& changes = {}) {
    state_ = state_at(scene_, scene_time, changes);
  }

 private:
  [[nodiscard]] PerEye<EyeMask> traced(const StereoView& views) {
    ShadowFrame frame;
    tracer_.trace({{.frame = FrameId{1},
                    .display_time = {},
                    .scene_time = state_.scene_time,
                    .views = views,
                    .lights = state_.light_changes}},
                  frame);
    return std::move(frame.masks);
  }

  [[nodiscard]] static Wrong wrong(const ShownReport& shown, const EyeMask& truth) {
    Wrong result{.mask_error = compare_masks(shown, truth).mask_error};
    const std::size_t lights = truth.layout().lights;
    double total = 0;
    for (std::size_t at = 0; at < shown.sources.size(); ++at) {
      if (shown.sources[at] == kSourceUncovered) continue;
      for (std::size_t i = 0; i < lights; ++i) {
        const bool lit = truth.lit(static_cast<std::uint32_t>(at % kSide_px),
                                   static_cast<std::uint32_t>(at / kSide_px), static_cast<std::uint32_t>(i));
        const int k = shown.visibility[at * lights + i];
        total += 1;
        result.dark += lit && k < 255 ? 1 : 0;
        result.lit += !lit && k >= 128 ? 1 : 0;
        result.shadowed += lit ? 0 : 1;
      }
    }
    result.dark /= total, result.lit /= total, result.shadowed /= total;
    return result;
  }

  Scene scene_;
  SceneState state_ = state_at(scene_, Time{});
  Tracer tracer_;
  std::unique_ptr<Renderer> renderer_;
  std::uint32_t frames_ = 0;
};

using ShadowMapsShown = OnLavapipe;

struct Bundled {
  const char* scene;
  double most_at_1024;  ///< mask error
};

class ShadowMapError : public OnLavapipe, public testing::WithParamInterface<Bundled> {};

TEST_P(ShadowMapError, IsBoundedAndFallsAsTheResolutionDoubles) {
  ShadowMapRig rig(device_, bundled(GetParam().scene));
  const Rigid<Stage, Head> head = head_at_camera(rig.scene());
  double before = 1;
  for (const std::uint32_t side_px : {256u, 512u, 1024u}) {
    const double error = rig.show_and_judge(head, {.side_px = side_px}).mask_error;
    EXPECT_LT(error, 0.8 * before) << side_px;
    before = error;
  }
  EXPECT_LT(before, GetParam().most_at_1024);
  EXPECT_LT(before, 0.75 * rig.show_and_judge(head, {.sharpness = 1}).mask_error) << "sharpened edges";
}

INSTANTIATE_TEST_SUITE_P(Scenes, ShadowMapError,
                         testing::Values(Bundled{"box_over_plane.gltf", 0.004}, Bundled{"room.glb", 0.02}));

/// Six walls that do not meet, and an obstacle in each direction of the cube and across its edges.
Scene walls_about_a_light() {
  SceneBuilder builder;
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f}) {
      glm::vec3 out(0.0f), u(0.0f), v(0.0f);
      out[axis] = 4 * side, u[(axis + 1) % 3] = 3.9f, v[(axis + 2) % 3] = 3.9f;
      builder.add(quad(out, u, v));
      const float along = side * (1.0f + 0.2f * static_cast<float>(axis));
      glm::vec3 before(0.3f, -0.2f, 0.4f);
      before[axis] = along;
      builder.add(box(before, glm::vec3(0.1f, 0.2f, 0.3f)));
      glm::vec3 across(0.1f);  // on the edge between two faces
      across[axis] = across[(axis + 1) % 3] = along;
      builder.add(box(across, glm::vec3(0.2f, 0.1f, 0.15f)));
    }
  builder.point_light({0.1, 0.05, -0.15});
  return builder.build();
}

TEST_F(ShadowMapsShown, EveryFaceOfACubeSeesItsOwnDirection) {
  ShadowMapRig rig(device_, walls_about_a_light());
  for (const glm::dvec3 ahead :
       {glm::dvec3(1, 0, 0.01), {-1, 0, 0.01}, {0.01, 1, 0}, {0.01, -1, 0}, {0.01, 0, 1}, {0.01, 0, -1}}) {
    SCOPED_TRACE(testing::Message() << ahead.x << ' ' << ahead.y << ' ' << ahead.z);
    const Wrong wrong = rig.show_and_judge(
        head_looking(glm::dvec3(ahead.y, ahead.z, ahead.x) * 1.5 - ahead * 2.0, ahead * 4.0), {});
    EXPECT_GT(wrong.shadowed, 0.02);
    EXPECT_LT(wrong.mask_error, 0.01);
  }
}

/// Planes at all slopes, under lights of every kind, without obstacles.
Scene bare_planes() {
  SceneBuilder builder;
  builder.add(quad({0, 0, 0}, {0, 0, 12}, {12, 0, 0}));
  builder.add(quad({-3, 0.3f, -3}, {0, 0, 0.8f}, {0.8f, 0.3f, 0}));
  builder.add(quad({3, 0.3f, -3}, {0, 0.3f, 0.8f}, {0.8f, -0.4f, 0}));
  builder.point_light({0.2, 1.1, -0.3});
  builder.spot_light({0, 5, -4}, {0.1, -1, 0.2}, 0.6f);
  builder.spot_light({-6, 1.5, -4}, {1, -0.3, 0}, 1.4f);  // too wide for one perspective projection
  builder.directional_light({0.3, -1, 0.1});
  builder.directional_light({1, -0.08, 0.2});
  return builder.build();
}

TEST_F(ShadowMapsShown, PlanesDoNotShadowThemselvesAtAnySlopeNorAtSeams) {
  Scene scene = bare_planes();
  scene.instances.resize(1);  // only the ground
  ShadowMapRig rig(device_, scene);
  for (const std::uint32_t radius : {0u, 1u, 3u})
    for (const std::uint32_t side_px : {128u, 1024u}) {
      SCOPED_TRACE(testing::Message() << "radius " << radius << ", " << side_px << " texels");
      const Wrong wrong =
          rig.show_and_judge(head_looking({0, 3, 5}, {0, 0, -2}), {.side_px = side_px, .pcf_radius = radius});
      EXPECT_EQ(wrong.dark, 0.0);
      EXPECT_LT(wrong.lit, 1e-3) << "near the rims of the spots";
    }
}

TEST_F(ShadowMapsShown, TiltedPlanesAreWrongOnlyAtTheirOutlines) {
  ShadowMapRig rig(device_, bare_planes());
  const Wrong wrong = rig.show_and_judge(head_looking({0, 3, 2}, {0, 0, -4}), {});
  EXPECT_LT(wrong.mask_error, 0.006);
}

enum class Kind : std::uint8_t { Point, Spot, WideSpot, Directional };

class ShadowMapLight : public OnLavapipe, public testing::WithParamInterface<Kind> {
 protected:
  /// A box that stands on the ground, under one light.
  static SceneBuilder stage() {
    SceneBuilder builder;
    builder.add(quad({0, 0, 0}, {0, 0, 4}, {4, 0, 0}));
    builder.add(box({0, 0.5f, 0}, {0.3f, 0.5f, 0.4f}));
    switch (GetParam()) {
      case Kind::Point:
        builder.point_light({1, 2.5, 0.5});
        break;
      case Kind::Spot:
        builder.spot_light({1.5, 2.5, 0.5}, {-0.5, -1, -0.1}, 0.6f);
        break;
      case Kind::WideSpot:
        builder.spot_light({1.5, 2.5, 0.5}, {-0.5, -1, -0.1}, 1.3f);
        break;
      case Kind::Directional:
        builder.directional_light({-0.5, -1, -0.2});
    }
    return builder;
  }
  const Rigid<Stage, Head> head_ = head_looking({-1.5, 2, 2.5}, {-0.3, 0.2, 0});
};

TEST_P(ShadowMapLight, CastsTheTracedShadowThatTouchesItsCaster) {
  SceneBuilder builder = stage();
  builder.add(quad({-0.8f, 0.4f, 0.9f}, {0, 0.4f, 0}, {0.4f, 0, 0.5f}));  // thin, standing on the ground
  ShadowMapRig rig(device_, builder.build());
  const Wrong wrong = rig.show_and_judge(head_, {});
  EXPECT_GT(wrong.shadowed, 0.03);
  EXPECT_LT(wrong.mask_error, 0.004);
  EXPECT_LT(wrong.lit, 0.002);
}

TEST_P(ShadowMapLight, BothSidesOfASingleSidedSurfaceCast) {
  for (const float up : {1.0f, -1.0f}) {
    SceneBuilder builder = stage();
    Material single;
    const std::uint32_t material = builder.material(single);
    builder.add(quad({-0.9f, 1.0f, 0.5f}, {0, 0, 0.3f}, {0.3f * up, 0, 0}), material);
    ShadowMapRig rig(device_, builder.build());
    EXPECT_LT(rig.show_and_judge(head_, {}).mask_error, 0.005) << up;
  }
}

TEST_P(ShadowMapLight, ShinesThroughTheHolesOfMaskedMaterials) {
  SceneBuilder builder = stage();
  Texture sieve{.image = Image<Rgba8>({4, 4})};
  for (std::size_t i = 0; i < sieve.image.pixels.size(); ++i)
    sieve.image.pixels[i] = Rgba8(200, 200, 200, (i + i / 4) % 2 == 0 ? 0 : 255);
  Material masked;
  masked.double_sided = true;
  masked.alpha_cutoff = 0.5f;
  masked.texture = builder.texture(sieve);
  builder.add(quad({0.3f, 1.6f, 0.2f}, {0, 0, 0.8f}, {0.8f, 0, 0}), builder.material(masked));
  ShadowMapRig rig(device_, builder.build());
  const Wrong wrong = rig.show_and_judge(head_, {.side_px = 2048});
  EXPECT_LT(wrong.mask_error, 0.012);
}

INSTANTIATE_TEST_SUITE_P(Kinds, ShadowMapLight,
                         testing::Values(Kind::Point, Kind::Spot, Kind::WideSpot, Kind::Directional));

TEST_F(ShadowMapsShown, ReportSaysThatAllIsKnownAndFresh) {
  ShadowMapRig rig(device_, bundled("room.glb"));
  rig.show(head_at_camera(rig.scene()), {});
  const ShownReport report = rig.renderer().report(Side::Left);
  const EyeErrors errors = compare_masks(report, report.mask);
  EXPECT_EQ(errors.newest, 1.0);
  EXPECT_EQ(errors.unknown + errors.stale + errors.neighbours, 0.0);
}

/// A caster and a light that move, and a light that does not.
Scene moving_scene() {
  SceneBuilder builder;
  builder.add(quad({0, 0, 0}, {0, 0, 4}, {4, 0, 0}));
  const std::uint32_t thing = builder.add(box({-0.5f, 0.8f, 0}, {0.3f, 0.2f, 0.4f}));
  builder.move(thing, {1, 0, 0});
  const std::uint32_t light = builder.point_light({0.3, 2.5, 0.5});
  builder.move(light, {0, 0, -1});
  builder.directional_light({-0.5, -1, -0.2});
  return builder.build();
}

TEST_F(ShadowMapsShown, AreDrawnAgainOnlyWhereSomethingMoved) {
  ShadowMapRig rig(device_, moving_scene());
  const Rigid<Stage, Head> head = head_looking({-1.5, 2, 2.5}, {0, 0.2, 0});
  ShadowMapSettings settings;
  const auto layers = [&](const Rigid<Stage, Head>& from) {
    const DrawTimes times = rig.show(from, settings);
    const DrawCounters counters = rig.renderer().counters();
    const std::array drawn{counters.map_layers_drawn, counters.map_layers_restored};
    EXPECT_EQ(times.maps > Duration{}, drawn[0] + drawn[1] > 0);
    EXPECT_LT(rig.wrong(from).mask_error, 0.006);
    return drawn;
  };
  using Layers = std::array<std::uint64_t, 2>;
  EXPECT_EQ(layers(head), (Layers{7, 0}));
  EXPECT_EQ(layers(moved(head, 0.1, {0.1, 0, 0})), (Layers{0, 0})) << "a moving head needs no new maps";
  rig.set(Time(std::chrono::milliseconds(500)));
  EXPECT_EQ(layers(head), (Layers{6, 1})) << "the point light has moved, the other has not";
  EXPECT_EQ(layers(head), (Layers{0, 0}));
  LightChanges changes;
  change(changes, 1, true, LightPose{{}, {glm::normalize(glm::dvec3(0.4, -1, 0))}});
  rig.set(Time(std::chrono::milliseconds(500)), changes);
  EXPECT_EQ(layers(head), (Layers{1, 0})) << "the viewer has changed one light";
  settings.redraw = Redraw::Always;
  EXPECT_EQ(layers(head), (Layers{7, 0}));
  EXPECT_EQ(layers(head), (Layers{7, 0}));
}

TEST_F(ShadowMapsShown, ALightThatIsOffTakesNoMapAndTheOthersStayRight) {
  ShadowMapRig rig(device_, moving_scene());
  const Rigid<Stage, Head> head = head_looking({-1.5, 2, 2.5}, {0, 0.2, 0});
  const double both = rig.show_and_judge(head, {}).mask_error;
  const std::uint64_t bytes = rig.renderer().counters().vertex_bytes_read;
  LightChanges changes;
  change(changes, 0, false, std::nullopt);
  rig.set(Time{}, changes);
  EXPECT_LT(rig.show_and_judge(head, {}).mask_error, 0.006);
  EXPECT_LT(rig.renderer().counters().vertex_bytes_read, bytes);
  change(changes, 0, true, std::nullopt);
  rig.set(Time{}, changes);
  EXPECT_EQ(rig.show_and_judge(head, {}).mask_error, both);
}

TEST_F(ShadowMapsShown, CostNothingUntilTheyAreUsedAndDoNotChangeMasks) {
  ShadowMapRig rig(device_, bundled("box_over_plane.gltf"));
  const Rigid<Stage, Head> head = head_at_camera(rig.scene());
  rig.show_traced(head);
  const PerEye<Image<Rgb8>> before = rig.renderer().read_shown();
  const DrawCounters without = rig.renderer().counters();
  EXPECT_EQ(without.memory.peak[gpu::Use::ShadowMaps], 0u);
  const ShadowMapSettings settings;
  rig.show(head, settings);
  const DrawCounters with = rig.renderer().counters();
  EXPECT_EQ(with.pipelines, without.pipelines + 1 + 1) << "casters, and one pass for both eyes";
  EXPECT_NEAR(static_cast<double>(with.memory.now[gpu::Use::ShadowMaps]),
              static_cast<double>(shadow_map_bytes(rig.scene(), settings).value()), 64 << 10);
  EXPECT_GT(psnr_db(rig.renderer().read_shown()[0], before[0]), 30.0);
  rig.show_traced(head);
  EXPECT_TRUE(rig.renderer().read_shown()[0].pixels == before[0].pixels);
}

}  // namespace
}  // namespace farshade
