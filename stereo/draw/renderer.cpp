#include "stereo/draw/renderer.h"

#include <algorithm>
#include <iterator>
#include <vector>

#include "stereo/draw/mask_passes.h"
#include "stereo/draw/read_back.h"
#include "stereo/gpu/frame_commands.h"
#include "stereo/gpu/frames_in_flight.h"
#include "stereo/plan/plan_masks.h"
#include "stereo/raster/gbuffer_transfer.h"
#include "stereo/raster/mesh_streams.h"
#include "stereo/reproject/shading.h"
#include "stereo/reproject/timewarp_pass.h"

namespace farshade {
namespace {

/// The kinds of parts of a frame. Each has its timestamps and descriptor sets, one set a frame.
enum class Part : std::uint8_t { Request, Picture, Timewarp };

/// The timestamps of a part in those of its frame: one before each of its stages, and one after the last.
struct Stamps {
  std::uint32_t first, count;
};
constexpr std::array<Stamps, 3> kStamps{{{0, 3}, {3, 5}, {8, 2}}};
constexpr std::uint32_t kAllStamps = 10;

constexpr const Stamps& stamps_of(Part part) {
  return kStamps[static_cast<std::size_t>(part)];
}

/// Adds the time until it is destroyed.
class AddedTime {
 public:
  explicit AddedTime(Duration& sum) : sum_(sum) {}
  AddedTime(const AddedTime&) = delete;
  AddedTime& operator=(const AddedTime&) = delete;
  ~AddedTime() { sum_ += watch_.elapsed(); }

 private:
  Duration& sum_;
  Stopwatch watch_;
};

class VulkanRenderer final : public Renderer {
 public:
  VulkanRenderer(const gpu::Device& device, const Scene& scene, DrawPlan plan, const RendererLimits& limits,
                 const SceneLevels& levels, FutureEdgeRayData edge_rays);

  void draw(const ShownFrame& frame) override;
  std::vector<std::function<void()>> compile_steps(const Reprojection& reprojection, PixelReport report,
                                                   Changes changes) override;
  void shade_again(const ShownFrame& frame) override;
  void keep_depth(const FrameMoment& request, std::size_t slot, PerEye<Image<float>>& into,
                  const PerEye<HiddenArea>* hidden) override;
  bool reproject_to_request(const FrameMoment& request, std::size_t slot, const TracedMask* base,
                            const PerEye<HiddenArea>* hidden) override;
  void read_reprojected(RequestReprojection& into) override;
  void draw_received(const GBufferPlanes& planes, const ShownFrame& frame) override;
  void show_timewarped(const PerEye<Image<Rgb8>>& picture, const StereoView& from,
                       const StereoView& shown) override;
  void timewarp_shown(const StereoView& from, const StereoView& shown) override;
  void draw_with_difference(const ShownFrame& frame, const PerEye<Image<Rgb8>>& difference,
                            const StereoView& from) override;
  void append(const gpu::Recording& record) override { now().last = commands_.record(record); }
  void submit() override;
  DrawTimes finish() override;
  void discard_times() override;
  void forget() override { masks_.forget(); }
  [[nodiscard]] bool has_depth(FrameId frame) const override { return masks_.has_depth(frame); }
  [[nodiscard]] const gpu::Image& shown() const override { return shading_.shown(); }
  [[nodiscard]] ShownDepth shown_depth() const override { return {*shown_depth_.image, shown_depth_.layer}; }
  [[nodiscard]] PerEye<Image<Rgb8>> read_shown() override;
  [[nodiscard]] ShownReport report(Side side) override {
    return report(side, {0, 0, size_.width, size_.height});
  }
  [[nodiscard]] ShownReport report(Side side, const TileRect& part) override {
    collect_all();
    return shading_.report(side, part);
  }
  [[nodiscard]] ShownSurface read_surface(Side side, glm::uvec2 pixel) override;
  [[nodiscard]] PerEye<Image<float>> read_distance() override;
  void read_gbuffer(GBufferPlanes& into) override {
    collect_all();
    transfer_.read(shown_depth_, into);
  }
  [[nodiscard]] DrawCounters counters() const override;
  [[nodiscard]] bool anything_moves() const override { return plan_.anything_moves(); }

 private:
  enum class Stage : std::uint8_t { Shade, Both, Received };
  /// A frame that the host prepares or the device may still work on.
  struct Frame {
    gpu::FrameCommands::Part last = 0;            ///< that was recorded
    std::array<bool, kStamps.size()> recorded{};  ///< kinds of parts that are not in `times` yet
    bool reprojects = false;                      ///< its request reprojects a mask
    bool draws_maps = false;                      ///< its picture draws shadow maps
    DrawTimes times;
  };
  [[nodiscard]] Frame& now() { return in_flight_[frames_.place()]; }
  void make_way_for(Part part);
  void collect(std::size_t place);
  void collect_all();
  gpu::FrameCommands::Part record(
      Part part,
      const std::function<void(const vk::raii::CommandBuffer&, const std::function<void()>&)>& stages);
  void place_depth(const ShownFrame& frame);
  void prepare_shading(const ShownFrame& frame);
  ShadowMaps& need_maps(const ShadowMapSettings& settings);
  void record_picture(const ShownFrame& frame, Stage stage);
  TimewarpPass& need_timewarp();
  void record_timewarp(const StereoView& from, const StereoView& shown, TimewarpPass::Source source,
                       TimewarpPass::Effect effect);
  void read_distance(DepthPlace place, Extent size, PerEye<Image<float>>& into);

  const gpu::Device& device_;
  const Scene& scene_;
  const DrawPlan plan_;
  Extent size_, traced_size_;
  gpu::FramesInFlight frames_;
  SceneBuffers buffers_;
  gpu::UploadBuffer frame_buffer_;  ///< one FrameData for all passes
  gpu::Image own_depth_image_;
  DepthPlace own_depth_;  ///< for shown views that differ from those of the frame's request
  MaskPasses masks_;
  GBufferPass gbuffer_;
  GBufferTransfer transfer_;
  std::optional<ShadowMaps> shadow_maps_;  ///< created at first use
  std::optional<EdgeRays> edge_rays_;      ///< set if the plan has them
  ShadingPass shading_;
  std::optional<TimewarpPass> timewarp_;       ///< created at first use
  DepthPlace shown_depth_;                     ///< of the last drawn frame
  std::optional<DepthPlace> requested_depth_;  ///< set if the depth pass must draw
  ReadBack read_back_;
  gpu::Timestamps stamps_;
  std::vector<Frame> in_flight_;              ///< by place
  gpu::FrameCommands::Part reprojected_ = 0;  ///< the newest part that reprojects a mask to a request
  gpu::FrameCommands commands_;  ///< last, because it waits for the device before anything is destroyed
};

VulkanRenderer::VulkanRenderer(const gpu::Device& device, const Scene& scene, DrawPlan plan,
                               const RendererLimits& limits, const SceneLevels& levels,
                               FutureEdgeRayData edge_rays)
    : device_(device),
      scene_(scene),
      plan_(settled(std::move(plan))),
      size_(limits.size),
      traced_size_(limits.traced_size),
      frames_(device, limits.frames),
      buffers_(make_scene_buffers(frames_, scene, plan_, levels)),
      frame_buffer_(gpu::make_upload_buffer(frames_, sizeof(gpu::FrameData),
                                            vk::BufferUsageFlagBits::eUniformBuffer, "frame",
                                            gpu::Use::Frame)),
      own_depth_image_(make_depth_image(device, limits.traced_size, 1, "depth of shown views")),
      own_depth_(made_readable(device, own_depth_image_)),
      masks_(frames_, scene, plan_, buffers_, frame_buffer_, limits, own_depth_),
      gbuffer_(frames_, scene, plan_, buffers_, frame_buffer_, limits.size),
      transfer_(frames_, gbuffer_, limits.size),
      shading_(frames_, plan_, &gbuffer_, masks_.depths(), masks_.masks(), frame_buffer_, masks_.motion(),
               shading_bytes(plan_, limits.size, limits.traced_size), limits.size,
               plan_.edge_rays ? &edge_rays_.emplace(frames_, scene.lights.size(), std::move(edge_rays))
                               : nullptr),
      shown_depth_(own_depth_),
      read_back_(device),
      stamps_(device, narrow<std::uint32_t>(frames_.count()) * kAllStamps),
      in_flight_(frames_.count()),
      commands_(device) {
  check(limits.traced_size.width >= size_.width && limits.traced_size.height >= size_.height,
        "traced views may be as large as shown views");
}

/// A frame has one part of each kind. Another one waits for the first.
void VulkanRenderer::make_way_for(Part part) {
  if (now().recorded[static_cast<std::size_t>(part)]) collect_all();
}

/// Waits for what was recorded of a frame, and adds its times.
void VulkanRenderer::collect(std::size_t place) {
  Frame& frame = in_flight_[place];
  commands_.wait(frame.last);
  const auto took = [&](Part part, std::uint32_t stage) {
    if (!frame.recorded[static_cast<std::size_t>(part)]) return Duration{};
    const std::uint32_t first = narrow<std::uint32_t>(place) * kAllStamps + stamps_of(part).first + stage;
    return stamps_.between(first, first + 1);
  };
  frame.times.depth += took(Part::Request, 0) + took(Part::Picture, 1);
  if (frame.reprojects) frame.times.request_reprojection += took(Part::Request, 1);
  frame.times.gbuffer += took(Part::Picture, 0);
  if (frame.draws_maps) frame.times.maps += took(Part::Picture, 2);
  frame.times.shade += took(Part::Picture, 3);
  frame.times.timewarp += took(Part::Timewarp, 0);
  frame.recorded = {};
  frame.reprojects = frame.draws_maps = false;
}

void VulkanRenderer::collect_all() {
  for (std::size_t i = 1; i <= frames_.count(); ++i) collect((frames_.place() + i) % frames_.count());
}

/// Records a part. `stages` calls its second argument after each stage but the last.
gpu::FrameCommands::Part VulkanRenderer::record(
    Part part,
    const std::function<void(const vk::raii::CommandBuffer&, const std::function<void()>&)>& stages) {
  const gpu::FrameCommands::Part recorded = commands_.record([&](const vk::raii::CommandBuffer& commands) {
    const std::uint32_t count = stamps_of(part).count,
                        first = narrow<std::uint32_t>(frames_.place()) * kAllStamps + stamps_of(part).first;
    stamps_.reset(commands, first, count);
    std::uint32_t stamp = first;
    const auto next_stage = [&] { stamps_.write(commands, stamp++); };
    next_stage();
    stages(commands, next_stage);
    next_stage();
    check_eq(stamp, first + count, "stages of a part");
  });
  now().recorded[static_cast<std::size_t>(part)] = true;  // not if recording has thrown
  now().last = recorded;
  return recorded;
}

void VulkanRenderer::submit() {
  const AddedTime added(now().times.total);
  commands_.submit();
}

DrawTimes VulkanRenderer::finish() {
  const Stopwatch watch;
  commands_.submit();
  collect(frames_.next_place());
  now().times.total += watch.elapsed();
  const DrawTimes of_host = now().times;
  frames_.next();
  DrawTimes times = std::exchange(now(), {}).times;
  times.total = of_host.total;
  times.triangles = of_host.triangles;
  times.frames_ago = narrow<std::uint32_t>(frames_.count()) - 1;
  return times;
}

void VulkanRenderer::discard_times() {
  if (now().last == 0) return;
  collect_all();
  frames_.restart();
  now() = {};
}

/// Chooses where the depth of the shown views goes, and that of the requested views if they differ.
void VulkanRenderer::place_depth(const ShownFrame& frame) {
  requested_depth_.reset();
  shown_depth_ = own_depth_;
  if (frame.request == nullptr || !reprojects_masks(plan_)) return;
  // In the views of a request less is hidden.
  const bool same = frame.request->views == frame.views &&
                    frame.request->scene_time == frame.state.scene_time &&
                    (frame.hidden == nullptr || !plan_.depth_pass);
  if (!same && !plan_.depth_pass) return;
  const std::optional<DepthPlace> place = masks_.ring().claim(frame.request->frame, frame.request_slot);
  if (!place) return;
  if (same) {
    shown_depth_ = *place;
    return;
  }
  requested_depth_ = place;
  PerEye<HiddenArea> hidden;
  if (frame.hidden != nullptr) hidden = hidden_in_request(*frame.hidden, frame.views, frame.request->views);
  masks_.need_depth_pass().prepare(
      frame.request->views,
      plan_.anything_moves() ? state_at(scene_, frame.request->scene_time) : frame.state, frame.detail,
      &hidden);
}

/// Selects the usable masks and prepares the shading pass with them.
void VulkanRenderer::prepare_shading(const ShownFrame& frame) {
  if (frame.shadow_maps != nullptr) {
    ShadowMaps& maps = need_maps(*frame.shadow_maps);
    maps.prepare(frame.views, frame.state);
    shading_.prepare(shown_depth_, frame.views, frame.state.light_set, maps);
    return;
  }
  const MasksInUse used = masks_.usable(frame.masks, frame.cube_mask, frame.state, frame.reprojection.lookup);
  shading_.prepare(shown_depth_, frame.views, frame.state.light_set, used, frame.reprojection);
}

/// The existing shadow maps if their settings match, otherwise new ones.
ShadowMaps& VulkanRenderer::need_maps(const ShadowMapSettings& settings) {
  if (!shadow_maps_ || shadow_maps_->settings() != settings) {
    collect_all();  // what the device may still read is destroyed
    shadow_maps_.reset();
    shadow_maps_.emplace(frames_, scene_, plan_, buffers_, frame_buffer_, settings);
  }
  return *shadow_maps_;
}

void VulkanRenderer::draw(const ShownFrame& frame) {
  const AddedTime added(now().times.total);
  make_way_for(Part::Picture);
  place_depth(frame);
  if (masks_.faces()) masks_.faces()->prepare(frame);
  gbuffer_.prepare(frame.views, frame.state, frame.detail, frame.hidden);
  prepare_shading(frame);
  record_picture(frame, Stage::Both);
}

std::vector<std::function<void()>> VulkanRenderer::compile_steps(const Reprojection& reprojection,
                                                                 PixelReport report, Changes changes) {
  if (plan_.anything_moves()) changes = Changes::Possible;
  collect_all();
  gbuffer_.prepare_warm_up();
  if (plan_.depth_pass) masks_.need_depth_pass().prepare_warm_up();
  frame_buffer_.write(0, gpu::FrameData{});  // pictures of no pixels
  std::vector<gpu::Recording> recordings{
      [this](const auto& commands) { gbuffer_.record(commands, own_depth_); }};
  if (plan_.depth_pass)
    recordings.emplace_back(
        [this](const auto& commands) { masks_.need_depth_pass().record(commands, own_depth_); });
  if (reprojects_masks(plan_)) recordings.push_back(masks_.need_reprojection().warm_up());
  std::ranges::copy(shading_.warm_ups(reprojection, report, changes), std::back_inserter(recordings));
  std::vector<std::function<void()>> steps;
  for (gpu::Recording& recording : recordings)  // one submission each, because each has a time limit
    steps.emplace_back([this, recording = std::move(recording)] { gpu::run_now(device_, recording); });
  return steps;
}

void VulkanRenderer::shade_again(const ShownFrame& frame) {
  const AddedTime added(now().times.total);
  make_way_for(Part::Picture);
  prepare_shading(frame);
  record_picture(frame, Stage::Shade);
}

void VulkanRenderer::keep_depth(const FrameMoment& request, std::size_t slot, PerEye<Image<float>>& into,
                                const PerEye<HiddenArea>* hidden) {
  make_way_for(Part::Request);
  const std::optional<DepthPlace> place = masks_.ring().claim(request.frame, slot);
  if (!place) throw vk::OutOfDeviceMemoryError("the depth of a request");
  DepthPass& pass = masks_.need_depth_pass();
  pass.prepare(request.views, state_at(scene_, request.scene_time, request.lights), Detail::Full, hidden);
  record(Part::Request,
         [&](const vk::raii::CommandBuffer& commands, const std::function<void()>& next_stage) {
           pass.record(commands, *place);
           next_stage();
         });
  now().times.triangles.depth += pass.scene_pass().triangles();
  read_distance(*place, request.views[0].size, into);
}

bool VulkanRenderer::reproject_to_request(const FrameMoment& request, std::size_t slot,
                                          const TracedMask* base, const PerEye<HiddenArea>* hidden) {
  make_way_for(Part::Request);
  if (!masks_.prepare(request, slot, base, hidden)) return false;
  now().reprojects = true;
  reprojected_ = record(
      Part::Request, [&](const vk::raii::CommandBuffer& commands, const std::function<void()>& next_stage) {
        masks_.record_depth(commands);
        next_stage();
        masks_.record_reprojection(commands);
      });
  now().times.triangles.depth += masks_.need_depth_pass().scene_pass().triangles();
  return true;
}

void VulkanRenderer::read_reprojected(RequestReprojection& into) {
  check(reprojected_ > 0, "a mask has been reprojected");
  commands_.wait(reprojected_);
  masks_.read(into);
}

void VulkanRenderer::draw_received(const GBufferPlanes& planes, const ShownFrame& frame) {
  const AddedTime added(now().times.total);
  ShownFrame direct = frame;
  direct.request = nullptr;
  direct.reprojection.lookup = Lookup::Direct;
  make_way_for(Part::Picture);
  place_depth(direct);
  transfer_.prepare(planes);
  prepare_shading(direct);
  record_picture(direct, Stage::Received);
}

void VulkanRenderer::record_picture(const ShownFrame& frame, Stage stage) {
  const bool draws_depth = stage != Stage::Shade && requested_depth_.has_value();
  const bool draws_faces = stage != Stage::Shade && masks_.faces().has_value();
  record(Part::Picture,
         [&](const vk::raii::CommandBuffer& commands, const std::function<void()>& next_stage) {
           if (stage == Stage::Received)
             transfer_.record(commands, shown_depth_);
           else if (stage != Stage::Shade)
             gbuffer_.record(commands, shown_depth_);
           next_stage();
           if (draws_depth) masks_.need_depth_pass().record(commands, *requested_depth_);
           if (draws_faces) masks_.faces()->record(commands);
           next_stage();
           if (frame.shadow_maps != nullptr) shadow_maps_->record(commands);
           next_stage();
           shading_.record(commands, frame.report);
         });
  now().draws_maps = frame.shadow_maps != nullptr && shadow_maps_->due();
  DrawnTriangles& triangles = now().times.triangles;
  if (stage == Stage::Both) triangles.gbuffer += gbuffer_.scene_pass().triangles();
  if (draws_depth) triangles.depth += masks_.need_depth_pass().scene_pass().triangles();
  if (draws_faces) triangles.depth += masks_.faces()->triangles();
  if (now().draws_maps) triangles.maps += shadow_maps_->scene_pass().triangles();
}

TimewarpPass& VulkanRenderer::need_timewarp() {
  if (!timewarp_) timewarp_.emplace(frames_, shading_.shown(), traced_size_);
  return *timewarp_;
}

void VulkanRenderer::show_timewarped(const PerEye<Image<Rgb8>>& picture, const StereoView& from,
                                     const StereoView& shown) {
  const AddedTime added(now().times.total);
  make_way_for(Part::Timewarp);
  need_timewarp().load(picture);
  record_timewarp(from, shown, TimewarpPass::Source::Loaded, TimewarpPass::Effect::Show);
}

void VulkanRenderer::timewarp_shown(const StereoView& from, const StereoView& shown) {
  const AddedTime added(now().times.total);
  make_way_for(Part::Timewarp);
  record_timewarp(from, shown, TimewarpPass::Source::Shown, TimewarpPass::Effect::Show);
}

void VulkanRenderer::draw_with_difference(const ShownFrame& frame, const PerEye<Image<Rgb8>>& difference,
                                          const StereoView& from) {
  ShownFrame unshadowed = frame;
  unshadowed.masks = {};
  unshadowed.shadow_maps = nullptr;
  draw(unshadowed);
  const AddedTime added(now().times.total);
  make_way_for(Part::Timewarp);
  need_timewarp().load(difference);
  record_timewarp(from, frame.views, TimewarpPass::Source::Loaded, TimewarpPass::Effect::Add);
}

void VulkanRenderer::record_timewarp(const StereoView& from, const StereoView& shown,
                                     TimewarpPass::Source source, TimewarpPass::Effect effect) {
  record(Part::Timewarp, [&](const vk::raii::CommandBuffer& commands, const std::function<void()>&) {
    need_timewarp().record(commands, from, shown, source, effect);
  });
}

PerEye<Image<Rgb8>> VulkanRenderer::read_shown() {
  collect_all();
  const auto pixels = read_back_.read<Rgba8>(shading_.shown(), vk::ImageLayout::eGeneral, 0, size_);
  PerEye<Image<Rgb8>> result{Image<Rgb8>(size_), Image<Rgb8>(size_)};
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    for (std::size_t i = 0; i < size_.pixels(); ++i)
      result[eye].pixels[i] = Rgb8(pixels[eye * size_.pixels() + i]);
  return result;
}

ShownSurface VulkanRenderer::read_surface(Side side, glm::uvec2 pixel) {
  collect_all();
  const GBufferTransfer::Pixel read = transfer_.read(shown_depth_, side, pixel);
  if (read.depth <= 0) return {};
  ShownSurface surface{.distance_m = static_cast<float>(kNearPlane_m / read.depth),
                       .normal = from_octahedral(read.normal),
                       .instance = {}};
  if (keeps_instances(plan_))
    surface.instance = {read.instance, gbuffer_.scene_pass().level_of(read.instance)};
  return surface;
}

PerEye<Image<float>> VulkanRenderer::read_distance() {
  PerEye<Image<float>> result;
  read_distance(shown_depth_, size_, result);
  return result;
}

void VulkanRenderer::read_distance(DepthPlace place, Extent size, PerEye<Image<float>>& into) {
  collect_all();
  const auto depths =
      read_back_.read<float>(*place.image, vk::ImageLayout::eShaderReadOnlyOptimal, place.layer, size);
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    into[eye].size = size;
    into[eye].pixels.resize(size.pixels());
    for (std::size_t i = 0; i < size.pixels(); ++i) {
      const float depth = depths[eye * size.pixels() + i];
      into[eye].pixels[i] = depth > 0 ? static_cast<float>(kNearPlane_m / depth) : 0.0f;
    }
  }
}

DrawCounters VulkanRenderer::counters() const {
  DrawCounters counters{.pipelines = shading_.pipelines(),
                        .bindings = shading_.bindings(),
                        .lookups = shading_.lookups(),
                        .mask_uploads = masks_.masks().uploads(),
                        .memory = device_.ledger->read()};
  const auto add = [&](const ScenePass& pass, bool drawn) {
    counters.bindings += pass.bindings();
    if (drawn) counters.vertex_bytes_read += pass.vertex_bytes_read();
  };
  add(gbuffer_.scene_pass(), true);
  counters.pipelines += masks_.depth_pipelines();
  counters.pipelines += gbuffer_.scene_pass().pipelines() + gbuffer_.hidden_pass().pipelines();
  counters.meshes_deformed = buffers_.deformed->deformed();
  if (const std::optional<DepthPass>& depth_pass = masks_.depth_pass()) {
    counters.pipelines += depth_pass->hidden_pass().pipelines();
    add(depth_pass->scene_pass(), requested_depth_.has_value());
  }
  const std::optional<CubeMaskFaces>& faces = masks_.faces();
  for (std::size_t pair = 0; faces && pair < faces->passes().size(); ++pair)
    add(faces->passes()[pair].scene_pass(), pair < faces->pairs());
  if (shadow_maps_) {
    add(shadow_maps_->scene_pass(), shadow_maps_->due());
    counters.pipelines += shadow_maps_->scene_pass().pipelines();
    counters.bindings += shadow_maps_->bindings().kinds.size();
    counters.map_layers_drawn = shadow_maps_->layers_drawn().drawn;
    counters.map_layers_restored = shadow_maps_->layers_drawn().restored;
  }
  if (masks_.reprojection()) {
    counters.pipelines += masks_.reprojection()->pipelines();
    counters.bindings += masks_.reprojection()->bindings();
  }
  if (timewarp_) {
    counters.pipelines += timewarp_->pipelines();
    counters.bindings += timewarp_->bindings();
  }
  for (const gpu::Bindings& set : buffers_.texture_sets) counters.bindings += set.kinds.size();
  return counters;
}

}  // namespace

ShadingPasses suited_passes(const gpu::Device& device) {
  return device.is_cpu ? ShadingPasses::Sorted : ShadingPasses::Single;
}

std::unique_ptr<Renderer> make_renderer(const gpu::Device& device, const Scene& scene, DrawPlan plan,
                                        const RendererLimits& limits, const SceneLevels& levels,
                                        FutureEdgeRayData edge_rays) {
  return std::make_unique<VulkanRenderer>(device, scene, std::move(plan), limits, levels,
                                          std::move(edge_rays));
}

std::unique_ptr<Renderer> make_renderer(const gpu::Device& device, const Scene& scene,
                                        const RendererLimits& limits) {
  DrawPlan plan = plan_for(scene, {.all_lights = true}).draw;
  plan.passes = suited_passes(device);
  return make_renderer(device, scene, std::move(plan), limits);
}

}  // namespace farshade
