#include "stereo/embed/visibility_recorder.h"

#include "stereo/draw/mask_passes.h"
#include "stereo/gpu/frame_commands.h"
#include "stereo/plan/plan_masks.h"

namespace farshade {
namespace {

/// A command buffer of the caller. A union, because the destructor of vk::raii::CommandBuffer would free it.
/// What is recorded uses our images and buffers, as what was recorded before does.
union ForeignCommands {
  ForeignCommands(const gpu::Device& device, VkCommandBuffer handle)
      : commands(device.logical, handle, VkCommandPool{}) {
    gpu::wait_for_earlier(commands);
  }
  ForeignCommands(const ForeignCommands&) = delete;
  ForeignCommands& operator=(const ForeignCommands&) = delete;
  ~ForeignCommands() {}

  vk::raii::CommandBuffer commands;
};

}  // namespace

struct VisibilityRecorder::State {
  State(gpu::Device adopted, const Scene& drawn, DrawPlan wanted, const RendererLimits& limits)
      : device(std::move(adopted)),
        plan(std::move(wanted)),
        frames(device, limits.frames),
        buffers(make_scene_buffers(frames, drawn, plan, {})),
        frame(gpu::make_upload_buffer(frames, sizeof(gpu::FrameData), vk::BufferUsageFlagBits::eUniformBuffer,
                                      "frame", gpu::Use::Frame)),
        any_depth(make_depth_image(device, {1, 1}, 1, "no depth")),
        passes(frames, drawn, plan, buffers, frame, limits, made_readable(device, any_depth)),
        shading(frames, plan, nullptr, passes.depths(), passes.masks(), frame, passes.motion(),
                shading_bytes(plan, limits.size, limits.traced_size), limits.size) {}

  gpu::Device device;
  const DrawPlan plan;
  gpu::FramesInFlight frames;
  SceneBuffers buffers;
  gpu::UploadBuffer frame;
  gpu::Image any_depth;  ///< bound where there is no depth
  MaskPasses passes;
  ShadingPass shading;
};

Expected<VisibilityRecorder> VisibilityRecorder::create(const gpu::ForeignDevice& device, const Scene& scene,
                                                        DrawPlan plan, const RendererLimits& limits) {
  if (!reprojects_masks(plan))
    return fail(Fault::Unsupported, "the plan reprojects no masks, so there is nothing to record");
  return gpu::adopt_device(device).map([&](gpu::Device&& adopted) {
    return VisibilityRecorder(std::make_unique<State>(std::move(adopted), scene, std::move(plan), limits));
  });
}

VisibilityRecorder::VisibilityRecorder(std::unique_ptr<State> state) : state_(std::move(state)) {}
VisibilityRecorder::VisibilityRecorder(VisibilityRecorder&&) noexcept = default;
VisibilityRecorder& VisibilityRecorder::operator=(VisibilityRecorder&&) noexcept = default;
VisibilityRecorder::~VisibilityRecorder() = default;

void VisibilityRecorder::begin_frame() {
  state_->frames.next();
}

bool VisibilityRecorder::record_request(VkCommandBuffer commands, const FrameMoment& request,
                                        std::size_t slot, const TracedMask* base,
                                        const PerEye<HiddenArea>* hidden) {
  if (!state_->passes.prepare(request, slot, base, hidden)) return false;
  const ForeignCommands foreign(state_->device, commands);
  state_->passes.record_depth(foreign.commands);
  state_->passes.record_reprojection(foreign.commands);
  return true;
}

void VisibilityRecorder::read_unknown(RequestReprojection& into) const {
  state_->passes.read(into);
}

void VisibilityRecorder::record_faces(VkCommandBuffer commands, std::span<const FaceRequest> faces,
                                      const SceneState& state) {
  std::optional<CubeMaskFaces>& kept = state_->passes.faces();
  if (!kept) return;
  kept->prepare({.views = {}, .state = state, .masks = {}, .reprojection = {}, .faces = faces});
  kept->record(ForeignCommands(state_->device, commands).commands);
}

void VisibilityRecorder::record_visibility(VkCommandBuffer commands, const VisibilityFrame& frame,
                                           const VisibilityImages& images) {
  ShadingPass& shading = state_->shading;
  const MasksInUse used =
      state_->passes.usable(frame.masks, frame.cube_mask, frame.state, frame.reprojection.lookup);
  shading.prepare({.view = images.depth}, frame.views, frame.state.light_set, used, frame.reprojection);
  shading.bind_images({.surfaces = images.surfaces, .visibilities = images.visibility});
  shading.record(ForeignCommands(state_->device, commands).commands, PixelReport::Off);
}

std::uint32_t VisibilityRecorder::visibility_layers() const {
  return kEyes * FARSHADE_QUADS(state_->plan.mask.lights);
}

void VisibilityRecorder::forget() {
  state_->passes.forget();
}

}  // namespace farshade
