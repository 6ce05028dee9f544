#include "stereo/embed/visibility_recorder.h"

#include <stdexcept>

#include "stereo/draw/mask_passes.h"
#include "stereo/gpu/frame_commands.h"
#include "stereo/plan/plan_masks.h"
#include "stereo/raster/max_instances.h"

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

namespace {

/// The renderer's surfaces may have any index of an instance: slots of those that the scene lacks are 0.
ShadingBytes bytes_of(const DrawPlan& plan, const RendererLimits& limits) {
  ShadingBytes bytes = shading_bytes(plan, limits.size, limits.traced_size);
  if (bytes.slots > 0) bytes.slots = kMaxInstances * sizeof(std::uint32_t);
  return bytes;
}

/// Why nothing can be recorded; empty if it can.
std::string refusal(const gpu::Device& device, const Scene& scene, const DrawPlan& plan,
                    const RendererLimits& limits) {
  if (!reprojects_masks(plan)) return "the plan reprojects no masks, so there is nothing to record";
  if (scene.lights.size() != plan.mask.lights || scene.meshes.size() != plan.surfaces.size())
    return "the plan is not one of this scene";
  if (scene.instances.size() > kMaxInstances)
    return std::to_string(scene.instances.size()) + " instances, and at most " +
           std::to_string(kMaxInstances) + " can be told apart";
  if (!fits_dispatches(limits.size, device.max_groups))
    return device.name + " does not allow the workgroups of a picture of this size";
  if (limits.frames == 0 || limits.size.pixels() == 0) return "no frame, or a frame without pixels";
  return "";
}

void must_fit(bool fits, const char* what) {
  if (!fits) throw std::invalid_argument(what);
}

}  // namespace

struct VisibilityRecorder::State {
  State(gpu::Device adopted, const Scene& drawn, DrawPlan wanted, const RendererLimits& most)
      : device(std::move(adopted)),
        plan(std::move(wanted)),
        frames(device, most.frames),
        buffers(make_scene_buffers(frames, drawn, plan, {})),
        frame(gpu::make_upload_buffer(frames, sizeof(gpu::FrameData), vk::BufferUsageFlagBits::eUniformBuffer,
                                      "frame", gpu::Use::Frame)),
        any_depth(make_depth_image(device, {1, 1}, 1, "no depth")),
        passes(frames, drawn, plan, buffers, frame, most, made_readable(device, any_depth)),
        shading(frames, plan, nullptr, passes.depths(), passes.masks(), frame, passes.motion(),
                bytes_of(plan, most), most.size),
        limits(most) {
    static_cast<void>(passes.need_reprojection().warm_up());  // makes the pipeline
  }

  gpu::Device device;
  const DrawPlan plan;
  gpu::FramesInFlight frames;
  SceneBuffers buffers;
  gpu::UploadBuffer frame;
  gpu::Image any_depth;  ///< bound where there is no depth
  MaskPasses passes;
  ShadingPass shading;
  const RendererLimits limits;
};

Expected<VisibilityRecorder> VisibilityRecorder::create(const gpu::ForeignDevice& device, const Scene& scene,
                                                        DrawPlan plan, const RendererLimits& limits,
                                                        std::optional<ShadingPasses> passes) {
  Expected<gpu::Device> adopted = gpu::adopt_device(device);
  if (!adopted) return tl::unexpected(adopted.error());
  if (const std::string why = refusal(*adopted, scene, plan, limits); !why.empty())
    return fail(Fault::Unsupported, why);
  plan.passes = passes.value_or(suited_passes(*adopted));
  plan.builds_late = false;
  return VisibilityRecorder(std::make_unique<State>(std::move(*adopted), scene, std::move(plan), limits));
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
  const Extent size = request.views[0].size, most = state_->limits.traced_size;
  must_fit(size == request.views[1].size && size.width <= most.width && size.height <= most.height,
           "both views of a request have one size, at most RendererLimits::traced_size");
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
  for (const View& view : frame.views)
    must_fit(view.size == state_->limits.size, "shown views have the size of RendererLimits::size");
  const MasksInUse used =
      state_->passes.usable(frame.masks, frame.cube_mask, frame.state, frame.reprojection.lookup);
  shading.prepare({.view = images.depth}, frame.views, frame.state.light_set, used, frame.reprojection);
  shading.bind_images(
      {.depth = images.depth, .surfaces = images.surfaces, .visibilities = images.visibility});
  shading.record(ForeignCommands(state_->device, commands).commands, PixelReport::Off);
}

std::uint32_t VisibilityRecorder::visibility_layers() const {
  return kEyes * FARSHADE_QUADS(state_->plan.mask.lights);
}

void VisibilityRecorder::forget() {
  state_->passes.forget();
}

}  // namespace farshade
