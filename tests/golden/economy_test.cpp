/// A scene does not pay for features that it does not use. A ladder of scenes adds one feature at a time, and
/// the counters must change by the cost of that feature only. With all features on, the picture stays the
/// same.
#include <deque>
#include <numeric>
#include <random>
#include <set>

#include "stereo/frame/cube_mask.h"
#include "stereo/frame/tiles.h"
#include "stereo/gltf/gltf.h"
#include "stereo/image/difference.h"
#include "stereo/plan/plan_masks.h"
#include "stereo/raster/scene_buffers.h"
#include "stereo/reproject/shading_layout.h"
#include "tests/golden/test_rig.h"
#include "tests/oracle/random_scenes.h"
#include "tests/oracle/scene_builder.h"
#include "tests/support/test_place.h"

namespace farshade {
namespace {

using gpu::Use;
using namespace std::chrono_literals;

constexpr Extent kSize{64, 64};
constexpr RendererLimits kLimits{.size = kSize, .traced_size = kSize, .depth_frames = 3};

enum class Feature : std::uint8_t {
  Texture,
  VertexColors,
  Holes,
  NineLights,
  ManyLights,
  MovingLight,
  MovingThing
};

/// One triangle in front of the eyes and one light, with `features`.
Scene scene_with(const std::set<Feature>& features) {
  const auto has = [&](Feature feature) { return features.contains(feature); };
  SceneBuilder builder;
  Material material;
  material.double_sided = true;
  if (has(Feature::Holes)) material.alpha_cutoff = 0.5f;
  if (has(Feature::Texture)) {
    Texture texture{.image = Image<Rgba8>({32, 32})};
    std::ranges::fill(texture.image.pixels, Rgba8(200, 100, 50, 255));
    material.texture = builder.texture(texture);
  }
  Mesh mesh = triangle_soup({{-1, -1, -3}, {1, -1, -3}, {0, 1, -3}});
  mesh.uvs.assign(has(Feature::Texture) ? 3 : 0, glm::vec2(0.5f));
  mesh.colors.assign(has(Feature::VertexColors) ? 3 : 0, glm::u8vec4(100, 200, 255, 255));
  const std::uint32_t thing = builder.add(mesh, builder.material(material));
  const std::uint32_t lights = has(Feature::ManyLights) ? 33 : has(Feature::NineLights) ? 9 : 1;
  for (std::uint32_t i = 0; i < lights; ++i) {
    const std::uint32_t light = builder.point_light({0.1 * i, 2, 0});
    if (i == 0 && has(Feature::MovingLight)) builder.move(light, {0.1, 0, 0});
  }
  if (has(Feature::MovingThing)) builder.move(thing, {0.1, 0, 0});
  return builder.build();
}

/// Eyes that look along -z from the origin. The left eye is `aside_m` to the left.
StereoView eyes_at(double aside_m) {
  StereoView views{look({0, 0, 0}, {0, 0, -1}, kSize.width), look({0, 0, 0}, {0, 0, -1}, kSize.width)};
  views[0].stage_from_eye.translation.x -= aside_m;
  return views;
}

/// A mask with all bits set.
Mask all_lit(MaskLayout layout, FrameId frame, const StereoView& views) {
  EyeMask bits(kSize, layout);
  for (std::uint32_t plane = 0; plane < layout.planes(); ++plane)
    for (std::uint32_t y = 0; y < kSize.height; ++y)
      for (std::uint32_t x = 0; x < kSize.width; ++x) bits.set_word(x, y, plane, layout.used_bits(plane));
  const ReceivedTiles all(TileGrid{kSize}.count(), all_planes_received(layout));
  return {frame, Time{}, views, {bits, bits}, {all, all}};
}

/// What a frame costs.
struct Cost : DrawCounters {
  std::size_t vertex_bytes = 0;  ///< of vertex streams and indices
  DrawnTriangles triangles{};
};

class Economy : public OnLavapipe {
 protected:
  /// Requests a mask for some views, and half a second later draws other views with it.
  Cost drawn(const Scene& scene, const SessionNeeds& needs = {}) {
    return drawn(scene, plan_for(scene, needs).draw);
  }
  Cost drawn(const Scene& scene, const DrawPlan& plan) {
    const std::unique_ptr<Renderer> renderer_owner = make_renderer(device_, scene, plan, kLimits);
    Renderer& renderer = *renderer_owner;
    const SceneState now = state_at(scene, Time(500ms));
    const StereoView shown = eyes_at(0.06), requested = eyes_at(0.08);
    const FrameMoment first{FrameId{1}, Time{}, Time{}, shown},
        second{FrameId{2}, Time{}, Time(500ms), requested};
    PerEye<Image<float>> distance;
    if (plan.depth_pass) renderer.keep_depth(first, 0, distance);
    const Mask mask = all_lit(plan.mask, first.frame, shown);
    const std::vector<TracedMask> masks{mask.traced_mask()};
    renderer.finish();
    renderer.draw({.views = shown,
                   .state = now,
                   .request = &second,
                   .masks = masks,
                   .reprojection = {},
                   .request_slot = 1});
    const DrawTimes times = renderer.finish();
    return {renderer.counters(), stream_bytes(scene, plan, {}).total(), times.triangles};
  }
};

/// The uses whose numbers of bytes differ.
std::string changes(const gpu::BytesByUse& before, const gpu::BytesByUse& after) {
  std::string text;
  for (std::size_t use = 0; use < gpu::kUses; ++use)
    if (before.bytes[use] != after.bytes[use])
      text += (text.empty() ? "" : ", ") + std::string(to_string(static_cast<Use>(use)));
  return text;
}

struct Rung {
  const char* name;
  Feature feature;
  // The cost of each feature.
  std::uint64_t pipelines, bindings, vertex_bytes, vertex_bytes_read;
  const char* memory;
};

constexpr std::uint64_t kCorners = 3, kBothEyes = 2;

// Each eye reads the streams once. With holes, the depth pass reads them, too.
const std::array kLadder{
    Rung{"texture", Feature::Texture, 0, 1, kCorners * 8, kCorners * 8 * kBothEyes, "vertices, textures"},
    Rung{"vertex colours", Feature::VertexColors, 0, 0, kCorners * 4, kCorners * 4 * kBothEyes, "vertices"},
    Rung{"holes", Feature::Holes, 0, 0, 0, kCorners * 12 * kBothEyes, ""},
    Rung{"nine lights: words of two bytes", Feature::NineLights, 0, 0, 0, 0, "frame, masks"},
    Rung{"33 lights: two planes", Feature::ManyLights, 0, 0, 0, 0, "frame, masks"},
    Rung{"a light that moves", Feature::MovingLight, 0, 0, 0, 0, ""},
    Rung{"a thing that moves", Feature::MovingThing, 1, 2, 0, 0, "motion"},
};

TEST_F(Economy, OneTriangleAndOneLightCostTheLeast) {
  const Cost counters = drawn(scene_with({}));
  EXPECT_EQ(counters.pipelines, 1u + 1u + 2u) << "G-buffer, depth, the easy and the hard pass";
  EXPECT_EQ(counters.bindings, 2u + 1u + 10u + kMaxMasks) << "the depth of each mask is an image";
  EXPECT_EQ(counters.vertex_bytes, kCorners * 16 + 8) << "indices of two bytes, padded";
  EXPECT_EQ(counters.triangles.gbuffer, kBothEyes);
  EXPECT_EQ(counters.triangles.depth, kBothEyes);
  EXPECT_EQ(counters.triangles.maps, 0u);
  EXPECT_EQ(counters.vertex_bytes_read, kBothEyes * (kCorners * 16 + 6 + kCorners * 12 + 6));
  for (const Use use : {Use::Textures, Use::Motion, Use::Report, Use::Other})
    EXPECT_EQ(counters.memory.peak[use], 0u) << to_string(use);
  EXPECT_EQ(counters.memory.peak[Use::ReadBack], kEyes * kSize.pixels() * 4) << "the depth that was kept";
}

TEST_F(Economy, EachFeatureCostsWhatItTakesAndNothingElse) {
  std::set<Feature> features;
  Cost before = drawn(scene_with(features));
  for (const Rung& rung : kLadder) {
    SCOPED_TRACE(rung.name);
    features.insert(rung.feature);
    const Cost after = drawn(scene_with(features));
    EXPECT_EQ(after.pipelines, before.pipelines + rung.pipelines);
    EXPECT_EQ(after.bindings, before.bindings + rung.bindings);
    EXPECT_EQ(after.vertex_bytes, before.vertex_bytes + rung.vertex_bytes);
    EXPECT_EQ(after.vertex_bytes_read, before.vertex_bytes_read + rung.vertex_bytes_read);
    EXPECT_EQ(changes(before.memory.now, after.memory.now), rung.memory);
    before = after;
  }
}

TEST_F(Economy, MasksTakeTheNarrowestWords) {
  const auto bytes_a_pixel = [](const std::set<Feature>& features) {
    return shading_bytes(plan_for(scene_with(features)).draw, kSize, kSize).mask.words / kSize.pixels();
  };
  EXPECT_EQ(bytes_a_pixel({}), 1u);
  EXPECT_EQ(bytes_a_pixel({Feature::NineLights}), 2u);
  EXPECT_EQ(bytes_a_pixel({Feature::ManyLights}), 8u);
}

TEST_F(Economy, MasksThatFitTheShownViewsNeedNothingToReprojectThem) {
  const Cost reprojected = drawn(scene_with({})), fitting = drawn(scene_with({}), {.reprojects = false});
  EXPECT_EQ(fitting.pipelines, 1u + 1u) << "G-buffer, and one pass for both eyes";
  EXPECT_EQ(fitting.bindings, reprojected.bindings - 3 - kMaxMasks)
      << "the depth pass, the list of hard pixels, the cube mask, and the depth of masks";
  EXPECT_EQ(fitting.memory.now[Use::Lists], 0u);
  EXPECT_EQ(fitting.memory.now[Use::GBuffer] * 3, reprojected.memory.now[Use::GBuffer] * 2);
  EXPECT_LE(fitting.memory.now[Use::Masks] * 4, reprojected.memory.now[Use::Masks] + 1024);
}

TEST_F(Economy, ASinglePassHasNoLists) {
  const Scene scene = scene_with({});
  DrawPlan plan = plan_for(scene).draw;
  const Cost sorted = drawn(scene, plan);
  plan.passes = ShadingPasses::Single;
  const Cost single = drawn(scene, plan);
  EXPECT_EQ(single.pipelines, sorted.pipelines - 1);
  EXPECT_EQ(single.bindings, sorted.bindings - 1);
  EXPECT_EQ(changes(sorted.memory.now, single.memory.now), "lists");
  EXPECT_EQ(client_memory(scene, plan, kLimits)[Use::Lists], single.memory.now[Use::Lists]);
  EXPECT_EQ(single.memory.now[Use::Lists], 0u);
}

TEST_F(Economy, TheOtherEyeIsLookedUpOnlyWhereItStandsElsewhere) {
  EXPECT_EQ(drawn(scene_with({})).lookups, 2u);
  EXPECT_EQ(drawn(scene_with({}), {.two_views = false}).lookups, 1u);
}

TEST_F(Economy, AllFeaturesTogetherCostMoreOfEverything) {
  const Cost needed = drawn(scene_with({})),
             everything = drawn(scene_with({}), {.kind = PlanKind::Everything});
  EXPECT_GT(everything.pipelines, needed.pipelines);
  EXPECT_GT(everything.bindings, needed.bindings);
  EXPECT_GT(everything.vertex_bytes, needed.vertex_bytes);
  EXPECT_GT(everything.vertex_bytes_read, needed.vertex_bytes_read);
  for (const Use use : {Use::Vertices, Use::Textures, Use::Masks, Use::Motion})
    EXPECT_GT(everything.memory.now[use], needed.memory.now[use]) << to_string(use);
}

TEST_F(Economy, EverythingIsBuiltBeforeTheFirstFrame) {
  const Scene scene = scene_with({});
  const std::unique_ptr<Renderer> needed_owner = make_renderer(device_, scene, kLimits);
  const Renderer& needed = *needed_owner;
  EXPECT_EQ(needed.counters().pipelines, 0u);
  const std::unique_ptr<Renderer> everything_owner =
      make_renderer(device_, scene, plan_for(scene, {.kind = PlanKind::Everything}).draw, kLimits);
  const Renderer& everything = *everything_owner;
  EXPECT_EQ(everything.counters().pipelines, drawn(scene, {.kind = PlanKind::Everything}).pipelines);
}

TEST_F(Economy, PipelinesAreCompiledAheadOneASubmission) {
  const Scene scene = scene_with({Feature::MovingThing});
  const DrawPlan plan = plan_for(scene).draw;
  const std::unique_ptr<Renderer> renderer_owner = make_renderer(device_, scene, plan, kLimits);
  Renderer& renderer = *renderer_owner;
  const auto steps = renderer.compile_steps({}, PixelReport::Off, Changes::Never);
  for (const auto& step : steps) step();
  EXPECT_EQ(renderer.counters().pipelines, steps.size());
}

/// However many passes draw it: the shown views, the requested ones and six faces of the cube mask.
TEST_F(Economy, AMeshIsDeformedOnceForEachTimeOfAFrame) {
  std::mt19937 random(3);
  const Scene scene = bending_figures(random, 3000);
  const DrawPlan plan = plan_for(scene).draw;
  ASSERT_GT(most_cube_mask_pairs(plan), 0u);
  const std::unique_ptr<Renderer> renderer_owner = make_renderer(device_, scene, plan, kLimits);
  Renderer& renderer = *renderer_owner;
  const auto meshes = static_cast<std::uint64_t>(
      std::ranges::count_if(scene.instances, [](const Instance& i) { return i.rig.has_value(); }));
  ASSERT_GT(meshes, 3u);
  const StereoView shown = eyes_at(0.06), requested = eyes_at(0.08);
  std::uint64_t before = 0;
  const auto draw_at = [&](std::uint32_t number, Duration now, Duration then) {
    const SceneState state = state_at(scene, Time(now));
    const FrameMoment request{FrameId{number}, Time{}, Time(then), requested};
    std::vector<FrameMoment> pairs;
    for (std::size_t pair = 0; pair < kCubeMaskPairs; ++pair)
      pairs.push_back({FrameId{kFirstCubeMaskFrame.value + 3 * number + static_cast<std::uint32_t>(pair)},
                       Time{}, Time(then), faces_about({{0, 0, 0}}, pair, face_size(kSize))});
    const std::vector<FaceRequest> faces{{pairs[0], 0}, {pairs[1], 1}, {pairs[2], 2}};
    renderer.draw({.views = shown,
                   .state = state,
                   .request = &request,
                   .masks = {},
                   .reprojection = {},
                   .request_slot = number % 3,
                   .faces = faces});
    const std::uint64_t now_deformed = renderer.counters().meshes_deformed, news = now_deformed - before;
    before = now_deformed;
    return news;
  };
  EXPECT_EQ(draw_at(1, 100ms, 180ms), 2 * meshes);
  EXPECT_EQ(draw_at(2, 114ms, 194ms), 2 * meshes);
  EXPECT_EQ(draw_at(3, 194ms, 274ms), meshes) << "the shown time was requested before";
  EXPECT_EQ(draw_at(4, 194ms, 274ms), 0u);
}

/// Draws frames as the client does: each frame requests a mask, and masks arrive three or four frames later.
TEST_F(Economy, AMaskIsUploadedOnceWhileItIsInUse) {
  constexpr std::uint32_t kFrames = 24, kSlots = 8;
  const Scene scene = scene_with({});
  const DrawPlan plan = plan_for(scene).draw;
  const std::unique_ptr<Renderer> renderer_owner =
      make_renderer(device_, scene, plan, {.size = kSize, .traced_size = kSize, .depth_frames = kSlots});
  Renderer& renderer = *renderer_owner;
  const SceneState state = state_at(scene, Time{});
  const StereoView views = eyes_at(0.06);
  std::deque<Mask> masks;  // newest first
  std::uint32_t traced = 0;
  for (std::uint32_t frame = 1; frame <= kFrames; ++frame) {
    const FrameMoment request{FrameId{frame}, Time{}, Time{}, views};
    // Every fifth frame no mask arrives, and the frame after it receives two.
    const std::uint32_t arrived = frame % 5 == 0 ? traced : frame < 4 ? 0 : frame - 3;
    std::uint64_t news = 0;
    for (; traced < arrived; ++traced, ++news)
      masks.push_front(all_lit(plan.mask, FrameId{traced + 1}, views));
    if (masks.size() > 6) masks.resize(6, masks.back());
    if (frame % 7 == 0 &&
        !masks.empty()) {  // a tile of the newest mask is lost: the content of the mask changes
      masks.front().received_tiles[0][0] = 0;
      news = std::max<std::uint64_t>(news, 1);
    }
    std::vector<TracedMask> traced_masks;
    for (const Mask& mask : masks) traced_masks.push_back(mask.traced_mask());
    const std::uint64_t before = renderer.counters().mask_uploads;
    renderer.draw({.views = views,
                   .state = state,
                   .request = &request,
                   .masks = traced_masks,
                   .reprojection = {},
                   .request_slot = frame % kSlots});
    EXPECT_EQ(renderer.counters().mask_uploads - before, news) << "frame " << frame;
  }
  EXPECT_GT(traced, kFrames / 2);
}

/// A device that allows no allocation of the depth of three requests has room for any number of requests.
TEST_F(Economy, TheDepthOfEachRequestIsAnAllocationOfItsOwn) {
  constexpr Extent kLarge{1024, 1024};
  constexpr std::uint32_t kRequests = 6;
  const std::uint64_t depth_bytes = kEyes * kLarge.pixels() * 4, most_bytes = 3 * depth_bytes - 1;
  device_.max_allocation_bytes = most_bytes;
  const Scene scene = scene_with({});
  const SceneState now = state_at(scene, Time{});
  const StereoView shown{look({0, 0, 0}, {0, 0, -1}, kLarge.width),
                         look({0, 0, 0}, {0, 0, -1}, kLarge.width)};
  const std::unique_ptr<Renderer> renderer =
      make_renderer(device_, scene, plan_for(scene, {.cube_mask = false}).draw,
                    {.size = kLarge, .traced_size = kLarge, .depth_frames = kRequests});
  std::uint64_t before = device_.ledger->read().now[Use::Depth];
  EXPECT_EQ(before, depth_bytes) << "that of the shown views";
  for (std::uint32_t i = 0; i < kRequests; ++i) {
    const FrameMoment request{FrameId{i + 1}, Time{}, Time{}, shown};
    renderer->draw({.views = shown,
                    .state = now,
                    .request = &request,
                    .masks = {},
                    .reprojection = {},
                    .request_slot = i});
    EXPECT_EQ(device_.ledger->read().now[Use::Depth], before += depth_bytes);
  }
  // The largest view: less than every device allows in one allocation (1 GiB, Vulkan 1.1).
  const std::uint64_t largest = kEyes * std::uint64_t{kMaxViewSide_px} * kMaxViewSide_px * 4;
  EXPECT_LE(largest, std::uint64_t{1} << 30);
}

/// `mask` converted to the words of `layout`.
Mask in_words_of(MaskLayout layout, Mask mask) {
  for (EyeMask& bits : mask.bits) {
    EyeMask wider(bits.size(), layout);
    for (std::uint32_t plane = 0; plane < layout.planes(); ++plane)
      for (std::uint32_t y = 0; y < bits.size().height; ++y)
        for (std::uint32_t x = 0; x < bits.size().width; ++x)
          wider.set_word(x, y, plane, bits.word(x, y, plane));
    bits = std::move(wider);
  }
  return mask;
}

class WholeScene : public OnLavapipe, public testing::WithParamInterface<std::string> {
 protected:
  static constexpr std::uint32_t kSide_px = 160;
  static constexpr Time kThen{}, kNow = Time(400ms);

  /// A frame drawn with a mask of another pose and time, and its report.
  struct Drawn {
    Shown shown;
    DrawCounters counters;
  };
  Drawn drawn(PlanKind kind) {
    const DrawPlan plan = plan_for(scene_, {.kind = kind, .all_lights = true}).draw;
    const std::unique_ptr<Renderer> renderer_owner = make_renderer(device_, scene_, plan, limits_);
    Renderer& renderer = *renderer_owner;
    const SceneState now = state_at(scene_, kNow);
    const StereoView requested = eyes_of(head_, kSide_px),
                     shown = eyes_of(moved(head_, 0.05, {0.02, 0, 0}), kSide_px);
    const FrameMoment first{FrameId{1}, kThen, kThen, requested}, second{FrameId{2}, kNow, kNow, requested};
    PerEye<Image<float>> distance;
    if (plan.depth_pass) renderer.keep_depth(first, 0, distance);
    const Mask mask = in_words_of(plan.mask, traced(first));
    const std::vector<TracedMask> masks{mask.traced_mask()};
    EXPECT_EQ(renderer.reproject_to_request({FrameId{3}, kThen, kThen, shown}, 2, masks.data()),
              plan.depth_pass);
    renderer.draw({.views = shown,
                   .state = now,
                   .request = &second,
                   .masks = masks,
                   .reprojection = {},
                   .report = PixelReport::On,
                   .request_slot = 1});
    Shown result{renderer.read_shown(), {renderer.report(Side::Left), renderer.report(Side::Right)}};
    return {std::move(result), renderer.counters()};
  }

  Mask traced(const FrameMoment& moment) const {
    Expected<Tracer> tracer = Tracer::create(scene_);
    ShadowFrame frame;
    tracer->trace({moment}, frame);
    const ReceivedTiles all(TileGrid{moment.views[0].size}.count(),
                            all_planes_received(frame.masks[0].layout()));
    return {moment.frame, kThen, moment.views, std::move(frame.masks), {all, all}};
  }

  Scene scene_ = load_scene(GetParam()).value();
  Rigid<Stage, Head> head_ = head_at_camera(scene_);
  RendererLimits limits_{{kSide_px, kSide_px}, {kSide_px + 32, kSide_px + 32}, 3};  ///< requests: as drawn
};

void expect_the_same(const Shown& a, const Shown& b) {
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    EXPECT_TRUE(a.pictures[eye].pixels == b.pictures[eye].pixels)
        << psnr_db(a.pictures[eye], b.pictures[eye]) << " dB";
    EXPECT_TRUE(a.reports[eye].visibility == b.reports[eye].visibility);
  }
}

/// Drivers round every allocation up. For a small use the rounding is more than a tenth of it.
constexpr double kRounding_bytes = 64 << 10;
constexpr std::uint64_t kUploadRounding_bytes = 256 << 10;  ///< FramesInFlight takes no less

void expect_predicted(const gpu::BytesByUse& predicted, const gpu::MemoryUse& measured) {
  for (std::size_t use = 0; use < gpu::kUses; ++use) {
    const auto bytes = static_cast<double>(predicted.bytes[use]);
    if (static_cast<Use>(use) == Use::Uploads) continue;  // those of a frame that writes everything
    EXPECT_NEAR(bytes, static_cast<double>(measured.peak.bytes[use]), bytes / 10 + kRounding_bytes)
        << to_string(static_cast<Use>(use));
  }
  EXPECT_LE(measured.peak[Use::Uploads], predicted[Use::Uploads] + kUploadRounding_bytes);
  const auto most = static_cast<double>(most_at_once(predicted));
  EXPECT_NEAR(most, static_cast<double>(measured.peak_total), most / 10);
}

TEST_P(WholeScene, LooksTheSameWithEverythingOnAndTakesTheMemoryThatIsPredicted) {
  std::optional<Shown> shown;
  for (const PlanKind kind : {PlanKind::Needed, PlanKind::Everything}) {
    SCOPED_TRACE(kind == PlanKind::Needed ? "needed" : "everything");
    device_.ledger = std::make_shared<gpu::Ledger>();
    const Drawn now = drawn(kind);
    expect_predicted(
        client_memory(scene_, plan_for(scene_, {.kind = kind, .all_lights = true}).draw, limits_),
        now.counters.memory);
    if (shown) expect_the_same(*shown, now.shown);
    shown = now.shown;
  }
}

TEST_P(WholeScene, TakesTheMemoryThatIsPredictedWithShadowMaps) {
  device_.ledger = std::make_shared<gpu::Ledger>();
  const DrawPlan plan = plan_for(scene_, {.reprojects = false, .all_lights = true}).draw;
  const ShadowMapSettings settings{.side_px = 256};
  const std::unique_ptr<Renderer> renderer_owner = make_renderer(device_, scene_, plan, limits_);
  Renderer& renderer = *renderer_owner;
  const SceneState now = state_at(scene_, kNow);
  renderer.draw({.views = eyes_of(head_, kSide_px),
                 .state = now,
                 .masks = {},
                 .reprojection = {},
                 .report = PixelReport::On,
                 .shadow_maps = &settings});
  static_cast<void>(renderer.read_shown());
  static_cast<void>(renderer.report(Side::Left));
  const gpu::BytesByUse predicted = client_memory(scene_, plan, limits_, {}, &settings);
  EXPECT_GT(predicted[Use::ShadowMaps], std::uint64_t{256} * 256 * 4);
  expect_predicted(predicted, renderer.counters().memory);
}

INSTANTIATE_TEST_SUITE_P(Bundled, WholeScene,
                         testing::Values(asset("box_over_plane.gltf"), asset("room.glb")));
#ifdef FARSHADE_SHARED_SCENES
INSTANTIATE_TEST_SUITE_P(Shared, WholeScene, testing::Values(shared_scene("modern_living_room.glb")));
#endif

}  // namespace
}  // namespace farshade
