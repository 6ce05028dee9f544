#include "stereo/reproject/request_reprojection_pass.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "shaders/request_reprojection.comp.spv.h"
#include "shaders/request_reprojection_data.h"
#include "stereo/frame/tiles.h"
#include "stereo/raster/frame_data.h"
#include "stereo/reproject/mask_quads.h"
#include "stereo/reproject/shading_layout.h"
#include "stereo/reproject/shading_motion.h"
#include "stereo/reproject/shown_eye.h"

namespace farshade {
namespace {

std::vector<gpu::BindingKind> request_reprojection_set() {
  using Type = vk::DescriptorType;
  const auto compute = vk::ShaderStageFlagBits::eCompute;
  const gpu::BindingKind uniform{Type::eUniformBuffer, compute}, storage{Type::eStorageBuffer, compute},
      texture{Type::eCombinedImageSampler, compute};
  return {uniform, uniform, storage, texture, storage, storage, texture};
}

}  // namespace

RequestReprojectionPass::RequestReprojectionPass(gpu::FramesInFlight& frames, const DrawPlan& plan,
                                                 const DepthPlace& any_depth, Extent traced_size)
    : frames_(frames),
      device_(frames.device()),
      plan_(plan),
      frame_buffer_(gpu::make_upload_buffer(frames, sizeof(gpu::FrameData),
                                            vk::BufferUsageFlagBits::eUniformBuffer, "requested frame",
                                            gpu::Use::Frame)),
      light_buffer_(gpu::make_upload_buffer(frames, (plan.mask.lights + 1) * sizeof(gpu::LightData),
                                            vk::BufferUsageFlagBits::eUniformBuffer, "requested lights",
                                            gpu::Use::Frame)),
      quad_bytes_(request_reprojection_bytes(plan, traced_size).quads),
      quads_(gpu::make_upload_buffer(frames, kEyes * quad_bytes_, vk::BufferUsageFlagBits::eStorageBuffer,
                                     "quads of a mask", gpu::Use::Masks)),
      reprojected_(gpu::make_readback_buffer(
          device_, request_reprojection_bytes(plan, traced_size).reprojected,
          vk::BufferUsageFlagBits::eStorageBuffer, "reprojected masks", gpu::Use::Masks)),
      unknown_(gpu::make_readback_buffer(device_, request_reprojection_bytes(plan, traced_size).unknown,
                                         vk::BufferUsageFlagBits::eStorageBuffer, "unknown blocks",
                                         gpu::Use::Masks)),
      nearest_(device_.logical.createSampler({})) {
  for (std::size_t place = 0; place < frames.count(); ++place) {
    const gpu::Bindings& bindings = bindings_.emplace_back(
        gpu::make_bindings(device_, request_reprojection_set(), "request reprojection"));
    gpu::bind_buffer(device_, bindings, 0, frame_buffer_.buffer());
    gpu::bind_buffer(device_, bindings, 1, light_buffer_.buffer());
    gpu::bind_buffer(device_, bindings, 2, quads_.buffer());
    gpu::bind_buffer(device_, bindings, 4, reprojected_);
    gpu::bind_buffer(device_, bindings, 5, unknown_);
    bind(bindings, {any_depth, any_depth});
  }
  layout_ = device_.logical.createPipelineLayout({.setLayoutCount = 1,
                                                  .pSetLayouts = &*bindings_.front().layout,
                                                  .pushConstantRangeCount = 1,
                                                  .pPushConstantRanges = &kShownEye});
}

void RequestReprojectionPass::bind(const gpu::Bindings& bindings, const Depths& depths) const {
  const auto read = vk::ImageLayout::eShaderReadOnlyOptimal;
  gpu::bind_image(device_, bindings, 3, {depths.requested.view, read, *nearest_});
  gpu::bind_image(device_, bindings, 6, {depths.base.view, read, *nearest_});
}

void RequestReprojectionPass::prepare(const FrameMoment& request, const Depths& depths,
                                      const TracedMask& base, const LightSet& lights, const Motion& since) {
  check(request.views[0].size == request.views[1].size, "both eyes of a request have one size");
  gpu::FrameData frame{};
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    frame.eye[eye] = eye_data(request.views[eye]);
    gpu::SourceData& source = frame.sources[eye * FARSHADE_MAX_SOURCES];
    source = source_data(pose_delta(request.views[eye], {}, base.views[eye], {}), base.views[eye]);
    source.place = {eye, eye * quad_bytes_ / 4, 0, 0};
    const EyeMask& bits = base.masks[eye];
    check(bits.layout() == plan_.mask, "a mask has the layout of the plan");
    const std::size_t bytes = quad_bytes(bits.size(), bits.layout());
    check(bytes <= quad_bytes_, "a mask has at most the traced size");
    write_quads(base, eye, quads_.view<std::byte>(eye * quad_bytes_, bytes));
  }
  const std::array<const Motion*, 1> motions{&since};
  write_stale(request.views, {.masks = motions}, frame);
  size_ = request.views[0].size;
  bind(bindings_now(), depths);
  frame_buffer_.write(0, frame);
  for (std::size_t i = 0; i < lights.lights.size(); ++i)
    light_buffer_.write(i, light_data(request.views, lights.lights[i], lights.exposure));
}

gpu::Recording RequestReprojectionPass::warm_up() {
  return [this, &pipeline = need_pipeline()](const vk::raii::CommandBuffer& commands) {
    commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *layout_, 0, *bindings_now().set, {});
    commands.bindPipeline(vk::PipelineBindPoint::eCompute, *pipeline);
    push_shown_eye(commands, layout_, 0);
    commands.dispatch(0, 1, 1);
  };
}

const vk::raii::Pipeline& RequestReprojectionPass::need_pipeline() {
  if (*pipeline_) return pipeline_;
  std::vector<std::uint32_t> constants(FARSHADE_REQUEST_REPROJECTION_CONSTANTS);
  constants[FARSHADE_REQUEST_REPROJECTION_LIGHTS] = plan_.mask.lights;
  constants[FARSHADE_REQUEST_REPROJECTION_WORD_BYTES] = plan_.mask.word_bytes();
  constants[FARSHADE_REQUEST_REPROJECTION_NEAR] =
      std::bit_cast<std::uint32_t>(static_cast<float>(kNearPlane_m));
  constants[FARSHADE_REQUEST_REPROJECTION_DETAIL] = std::bit_cast<std::uint32_t>(plan_.detail_px);
  constants[FARSHADE_REQUEST_REPROJECTION_MOVED] = std::ranges::find(plan_.moves, true) != plan_.moves.end();
  pipeline_ = gpu::make_compute_pipeline(device_, layout_, request_reprojection_comp_spv, constants,
                                         "request reprojection");
  return pipeline_;
}

void RequestReprojectionPass::record(const vk::raii::CommandBuffer& commands) {
  gpu::record_uploads(commands, {&frame_buffer_, &light_buffer_, &quads_});
  commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *layout_, 0, *bindings_now().set, {});
  const Extent blocks = blocks_of(size_);
  commands.bindPipeline(vk::PipelineBindPoint::eCompute, *need_pipeline());
  for (std::uint32_t eye = 0; eye < kEyes; ++eye) {
    push_shown_eye(commands, layout_, eye);
    commands.dispatch(
        (blocks.width + FARSHADE_REQUEST_REPROJECTION_GROUP - 1) / FARSHADE_REQUEST_REPROJECTION_GROUP,
        blocks.height, 1);
  }
  const vk::MemoryBarrier2 memory{.srcStageMask = vk::PipelineStageFlagBits2::eComputeShader,
                                  .srcAccessMask = vk::AccessFlagBits2::eShaderWrite,
                                  .dstStageMask = vk::PipelineStageFlagBits2::eHost,
                                  .dstAccessMask = vk::AccessFlagBits2::eHostRead};
  commands.pipelineBarrier2({.memoryBarrierCount = 1, .pMemoryBarriers = &memory});
}

void RequestReprojectionPass::read(RequestReprojection& into) const {
  const Extent blocks = blocks_of(size_);
  const TileGrid grid{size_};
  const std::size_t word_bytes = plan_.mask.word_bytes(), row_bytes = size_.width * word_bytes;
  const std::size_t padded_bytes = std::size_t{blocks.width} * kBlockSide_px * word_bytes;
  const std::byte* reprojected = reprojected_.as<std::byte>().data();
  const std::uint32_t* unknown = unknown_.as<std::uint32_t>().data();
  into.requested.lights = plan_.mask.lights;
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    EyeMask& mask = into.masks[eye];
    if (mask.size() != size_ || mask.layout() != plan_.mask) mask = EyeMask(size_, plan_.mask);
    for (std::uint32_t plane = 0; plane < plan_.mask.planes(); ++plane) {
      std::byte* row = mask.bytes().data() + plane * size_.pixels() * word_bytes;
      for (std::uint32_t y = 0; y < size_.height; ++y, row += row_bytes)
        std::memcpy(row, reprojected + y * padded_bytes, row_bytes);
      reprojected += std::size_t{blocks.height} * kBlockSide_px * padded_bytes;
    }
    std::vector<RequestedTile>& requested = into.requested.tiles[eye];
    std::vector<BlockBits>& covered = into.covered[eye];
    requested.assign(grid.count(), {});
    covered.assign(grid.count(), kNoBlocks);
    for (std::uint32_t y = 0; y < blocks.height; ++y)
      for (std::uint32_t x = 0; x < blocks.width; ++x, ++unknown) {
        const std::uint32_t tile = y / kTileBlocks * grid.columns() + x / kTileBlocks;
        const std::uint32_t block = y % kTileBlocks * kTileBlocks + x % kTileBlocks;
        requested[tile].add(block, *unknown & ~FARSHADE_REQUEST_REPROJECTION_COVERED);
        if ((*unknown & FARSHADE_REQUEST_REPROJECTION_COVERED) != 0)
          covered[tile] |= static_cast<BlockBits>(1u << block);
      }
  }
}

}  // namespace farshade
