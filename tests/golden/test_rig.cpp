#include "tests/golden/test_rig.h"

#include <cmath>
#include <cstdlib>
#include <functional>
#include <glm/geometric.hpp>
#include <random>
#include <stdexcept>
#include <string_view>

#include "stereo/base/check.h"
#include "stereo/frame/tiles.h"
#include "stereo/gltf/gltf.h"
#include "stereo/head/head_recording.h"
#include "stereo/math/rotation.h"
#include "stereo/plan/scene_plan.h"
#include "tests/oracle/scene_builder.h"
#include "tests/support/test_place.h"

namespace farshade {
namespace {

/// The value. Throws the error, so that the test fails with it.
template <class T>
T value_of(Expected<T> value) {
  if (!value) throw std::runtime_error(value.error().what);
  return std::move(*value);
}

gpu::Device& shared_device() {
  static gpu::Device device =
      value_of(gpu::open_device({.name_contains = test_gpu(), .validation = gpu::Validation::On}));
  return device;
}

ShadingPasses tested_passes(const gpu::Device& device) {
  const char* const named = std::getenv("FARSHADE_PASSES");
  if (named == nullptr) return suited_passes(device);
  return std::string_view(named) == "single" ? ShadingPasses::Single : ShadingPasses::Sorted;
}

/// A plan that keeps all lights.
DrawPlan plan_of(const Scene& scene, float detail_px, ShadingPasses passes) {
  DrawPlan plan = plan_for(scene, {.all_lights = true, .detail_px = detail_px}).draw;
  plan.passes = passes;
  return plan;
}

constexpr double kEyeDistance_m = 0.063;
constexpr EyeFov kLeftFov{-0.60, 0.50, 0.52, -0.56};
constexpr double kWallDistance_m = 2, kWallFov_rad = 1.4;

/// The width of a pixel's footprint at distance 1, in views of a SteppedWall.
double pixel_width(std::uint32_t side_px) {
  return 2 * std::tan(kWallFov_rad / 2) / side_px;
}

}  // namespace

OnLavapipe::OnLavapipe()
    : device_(shared_device()),
      earlier_messages_(device_.validation_log->messages().size()),
      max_allocations_(device_.max_allocations),
      max_allocation_bytes_(device_.max_allocation_bytes),
      max_image_side_px_(device_.max_image_side_px),
      max_image_layers_(device_.max_image_layers),
      max_groups_(device_.max_groups),
      max_storage_bytes_(device_.max_storage_bytes),
      max_texels_(device_.max_texels),
      image_limits_(device_.image_limits) {
  device_.ledger = std::make_shared<gpu::Ledger>();
}

OnLavapipe::~OnLavapipe() {
  device_.max_allocations = max_allocations_;
  device_.max_allocation_bytes = max_allocation_bytes_;
  device_.max_image_side_px = max_image_side_px_;
  device_.max_image_layers = max_image_layers_;
  device_.max_groups = max_groups_;
  device_.max_storage_bytes = max_storage_bytes_;
  device_.max_texels = max_texels_;
  device_.image_limits = image_limits_;
  device_.pipelines = nullptr;
  const std::vector<std::string> messages = device_.validation_log->messages();
  for (std::size_t i = earlier_messages_; i < messages.size(); ++i) ADD_FAILURE() << messages[i];
}

Scene bundled(const char* name) {
  return value_of(load_scene(asset(name)));
}

Scene with_lights(Scene scene, std::uint32_t count) {
  const std::vector<Light> given = state_at(scene, Time{}).light_set.lights;
  if (scene.lights.size() > count) scene.lights.resize(count);
  for (auto i = static_cast<std::uint32_t>(scene.lights.size()); i < count; ++i) {
    Node node;
    const double turn = 2.4 * i;  // about the golden angle, so that no two lights have one position
    node.rest.translation =
        given[i % given.size()].position.v + glm::dvec3(std::cos(turn), 0.0, std::sin(turn)) * (0.02 * i);
    LightSource light;
    light.node = narrow<std::uint32_t>(scene.nodes.size());
    scene.lights.push_back(light);
    scene.nodes.push_back(node);
  }
  return scene;
}

Rigid<Stage, Head> head_at_camera(const Scene& scene) {
  const Rigid<Stage, Eye> camera = scene.camera.value();
  return {camera.rotation, camera.translation};
}

Rigid<Stage, Head> head_looking(const glm::dvec3& eye, const glm::dvec3& target) {
  const Rigid<Stage, Eye> camera = look(eye, target, 1).stage_from_eye;
  return {camera.rotation, camera.translation};
}

Rigid<Stage, Head> moved(const Rigid<Stage, Head>& head, double yaw_rad, const glm::dvec3& step_m) {
  return head * Rigid<Head, Head>{rotation_exp({0, yaw_rad, 0}), step_m};
}

StereoView eyes_of(const Rigid<Stage, Head>& head, std::uint32_t side_px) {
  const EyeFov right{-kLeftFov.right_rad, -kLeftFov.left_rad, kLeftFov.up_rad, kLeftFov.down_rad};
  StereoView views;
  for (const Side side : kSides)
    views[index_of(side)] = {head * head_from_eye(side, kEyeDistance_m),
                             side == Side::Left ? kLeftFov : right,
                             {side_px, side_px}};
  return views;
}

Scene SteppedWall::scene() const {
  constexpr float kHalfLength_m = 4;
  const glm::vec3 along = kHalfLength_m * glm::normalize(glm::vec3(1, 0, slope)), up(0, 9, 0);
  const double nearer = kWallDistance_m * (1 - 1 / (1 + step * pixel_width(side_px)));
  SceneBuilder builder;
  builder.add(quad(-along, along, up));
  builder.add(quad(along + glm::vec3(0, 0, nearer), along, up));
  builder.directional_light({0, 0, -1});
  return builder.build();
}

StereoView SteppedWall::views(double left_px) const {
  const double x = left_px * pixel_width(side_px) * kWallDistance_m;
  const View view = look({x, 0, kWallDistance_m}, {x, 0, 0}, side_px, kWallFov_rad);
  return {view, view};
}

TracedMask Mask::traced_mask() const {
  std::uint64_t content = 0;
  const auto add = [&content](const void* data, std::size_t bytes) {
    const std::string_view text(static_cast<const char*>(data), bytes);
    content = content * 1'000'003 + std::hash<std::string_view>{}(text);
  };
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    add(bits[eye].bytes().data(), bits[eye].bytes().size());
    add(received_tiles[eye].data(), received_tiles[eye].size());
  }
  return {frame,          scene_time, scene_time,         views,     bits,
          received_tiles, content,    light_set_revision, &requested};
}

Mask with_noise(Mask mask, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  for (EyeMask& bits : mask.bits)
    for (std::uint32_t plane = 0; plane < bits.layout().planes(); ++plane)
      for (std::uint32_t y = 0; y < bits.size().height; ++y)
        for (std::uint32_t x = 0; x < bits.size().width; ++x)
          bits.set_word(x, y, plane, static_cast<std::uint32_t>(random()) & bits.layout().used_bits(plane));
  return mask;
}

bool same_bits(const EyeMask& a, glm::uvec2 at, const EyeMask& b, glm::uvec2 there) {
  for (std::uint32_t plane = 0; plane < a.layout().planes(); ++plane)
    if (a.word(at.x, at.y, plane) != b.word(there.x, there.y, plane)) return false;
  return true;
}

void for_pixels(Extent size, const std::function<void(std::uint32_t, std::uint32_t)>& visit) {
  for (std::uint32_t y = 0; y < size.height; ++y)
    for (std::uint32_t x = 0; x < size.width; ++x) visit(x, y);
}

std::uint32_t requested_bits(const RequestedBlocks& requested, std::size_t eye, Extent size,
                             glm::uvec2 pixel) {
  if (requested.tiles[eye].empty()) return ~0u;
  const std::size_t tile = pixel.y / kTileSide_px * TileGrid{size}.columns() + pixel.x / kTileSide_px;
  const auto block = std::countr_zero(block_bit(pixel.x % kTileSide_px, pixel.y % kTileSide_px));
  return requested.tiles[eye][tile].at(static_cast<std::uint32_t>(block)) * 0x01010101u;
}

void for_covered(const Shown& shown, const Visit& visit) {
  for (const Side side : kSides) {
    const ShownReport& report = shown.reports[index_of(side)];
    const Extent size = report.mask.size();
    for (std::uint32_t y = 0; y < size.height; ++y)
      for (std::uint32_t x = 0; x < size.width; ++x)
        if (const std::uint8_t source = report.sources[std::size_t{y} * size.width + x];
            source != kSourceUncovered)
          visit(side, x, y, source);
  }
}

TestRig::TestRig(const gpu::Device& device, Scene scene, std::uint32_t side_px, std::uint32_t depth_frames,
                 const std::function<DrawPlan(const Scene&)>& plan_of, FutureEdgeRayData edge_rays)
    : scene_(std::move(scene)),
      state_(state_at(scene_, Time{})),
      side_px_(side_px),
      depth_frames_(depth_frames),
      tracer_(std::make_unique<Tracer>(value_of(Tracer::create_reference(scene_)))),
      renderer_(make_renderer(
          device, scene_, plan_of(scene_),
          RendererLimits{{side_px, side_px}, {side_px + side_px / 4, side_px + side_px / 4}, depth_frames},
          {}, std::move(edge_rays))) {}

TestRig::TestRig(const gpu::Device& device, Scene scene, std::uint32_t side_px, std::uint32_t depth_frames,
                 float detail_px, std::optional<ShadingPasses> passes)
    : TestRig(device, std::move(scene), side_px, depth_frames, [&](const Scene& its) {
        return plan_of(its, detail_px, passes.value_or(tested_passes(device)));
      }) {}

EdgeRayData edge_ray_data(const gpu::Device& device, const Scene& scene) {
  return make_edge_ray_data(
      edge_ray_input(scene, plan_of(scene, 0, ShadingPasses::Sorted), device.max_texels));
}

TestRig TestRig::with_edge_rays(const gpu::Device& device, Scene scene, std::uint32_t side_px) {
  std::promise<EdgeRayData> data;
  data.set_value(edge_ray_data(device, scene));
  return with_edge_rays(device, std::move(scene), side_px, data.get_future().share());
}

TestRig TestRig::with_edge_rays(const gpu::Device& device, Scene scene, std::uint32_t side_px,
                                FutureEdgeRayData data) {
  constexpr std::uint32_t kDepthFrames = 8;
  const auto plan_of_rays = [](const Scene& its) {
    DrawPlan plan = plan_of(its, 0, ShadingPasses::Sorted);
    plan.edge_rays = true;
    return plan;
  };
  return {device, std::move(scene), side_px, kDepthFrames, plan_of_rays, std::move(data)};
}

Mask TestRig::trace(FrameId frame, const StereoView& views) {
  const Time now = state_.scene_time;
  ShadowFrame traced;
  tracer_->trace({{.frame = frame,
                   .display_time = now,
                   .scene_time = now,
                   .views = views,
                   .lights = state_.light_changes}},
                 traced);
  const ReceivedTiles all(TileGrid{views[0].size}.count(), all_planes_received(traced.masks[0].layout()));
  return {frame, now, views, std::move(traced.masks), {all, all}, traced.light_set_revision, {}};
}

Mask TestRig::ask(FrameId frame, const StereoView& views) {
  const Time now = state_.scene_time;
  const FrameMoment request{.frame = frame, .display_time = now, .scene_time = now, .views = views};
  renderer_->keep_depth(request, frame.value % depth_frames_, requested_distance_);
  return trace(frame, views);
}

std::optional<RequestReprojection> TestRig::reproject_to_request(FrameId frame, const StereoView& views,
                                                                 const Mask& base) {
  const Time now = state_.scene_time;
  const FrameMoment request{
      .frame = frame, .display_time = now, .scene_time = now, .views = views, .lights = state_.light_changes};
  RequestReprojection reprojected;
  PerEye<HiddenArea> hidden;
  if (hidden_) hidden = hidden_in_request(*hidden_, views, views);
  const TracedMask mask = base.traced_mask();
  if (!renderer_->reproject_to_request(request, frame.value % depth_frames_, &mask, &hidden))
    return std::nullopt;
  renderer_->read_reprojected(reprojected);
  return reprojected;
}

Mask TestRig::ask_for_unknown(FrameId frame, const StereoView& views, const Mask& base) {
  RequestReprojection reprojected = reproject_to_request(frame, views, base).value();
  Mask mask = trace(frame, views);
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for_pixels(views[eye].size, [&](std::uint32_t x, std::uint32_t y) {
      const std::uint32_t requested = requested_bits(reprojected.requested, eye, views[eye].size, {x, y});
      for (std::uint32_t plane = 0; plane < mask.bits[eye].layout().planes(); ++plane)
        mask.bits[eye].set_word(x, y, plane,
                                (mask.bits[eye].word(x, y, plane) & requested) |
                                    (reprojected.masks[eye].word(x, y, plane) & ~requested));
    });
  mask.requested = std::move(reprojected.requested);
  return mask;
}

std::vector<Mask> TestRig::ask_cube_mask(Point<Stage> centre) {
  std::vector<Mask> masks;
  std::vector<FrameMoment> requests;
  for (std::size_t pair = 0; pair < kCubeMaskPairs; ++pair) {
    const FrameId frame{kFirstCubeMaskFrame.value + narrow<std::uint32_t>(pair)};
    const StereoView faces = faces_about(centre, pair, face_size({side_px_, side_px_}));
    requests.push_back(
        {.frame = frame, .display_time = state_.scene_time, .scene_time = state_.scene_time, .views = faces});
    masks.push_back(trace(frame, faces));
  }
  std::vector<FaceRequest> requested;
  for (const FrameMoment& request : requests) requested.push_back({request, pair_of(request.frame)});
  const StereoView views = eyes(head());
  ShownFrame frame = shown_frame(views, {}, {});
  frame.faces = requested;
  renderer_->draw(frame);
  return masks;
}

Shown TestRig::show(const StereoView& views, const std::vector<TracedMask>& masks,
                    const Reprojection& reprojection, const std::vector<Mask>& cube_mask) {
  std::vector<TracedMask> faces;
  for (const Mask& pair : cube_mask) faces.push_back(pair.traced_mask());
  ShownFrame frame = shown_frame(views, masks, reprojection);
  frame.cube_mask = faces;
  renderer_->draw(frame);
  return {renderer_->read_shown(), {renderer_->report(Side::Left), renderer_->report(Side::Right)}};
}

PerEye<Image<Rgb8>> TestRig::show_reference(const StereoView& views) {
  const Mask truth = trace(FrameId{}, views);
  return show(views, {truth.traced_mask()}, {.lookup = Lookup::Direct}).pictures;
}

ShownFrame TestRig::shown_frame(const StereoView& views, std::span<const TracedMask> masks,
                                const Reprojection& reprojection) const {
  return {.views = views,
          .state = state_,
          .masks = masks,
          .reprojection = reprojection,
          .report = PixelReport::On,
          .hidden = hidden_ ? &*hidden_ : nullptr};
}

}  // namespace farshade
