#include "stereo/raster/hidden_pass.h"

namespace farshade {

void HiddenPass::prepare(const PerEye<HiddenArea>* hidden, const StereoView& views) {
  counts_ = {};
  if (hidden == nullptr || ((*hidden)[0].corners.empty() && (*hidden)[1].corners.empty())) return;
  need_pipeline();
  load(*hidden);
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const glm::dmat4 clip = clip_from_eye(tangents_of(views[eye].fov));
    drawn_[eye] = {.scale = {clip[0][0], clip[1][1]}, .offset = {-clip[2][0], -clip[2][1]}};
  }
}

void HiddenPass::load(const PerEye<HiddenArea>& hidden) {
  const std::size_t bytes = (hidden[0].corners.size() + hidden[1].corners.size()) * sizeof(glm::vec2);
  if (corners_.bytes() < bytes) {
    frames_.keep(std::make_shared<gpu::UploadBuffer>(std::move(corners_)));
    corners_ = gpu::make_upload_buffer(frames_, bytes, vk::BufferUsageFlagBits::eVertexBuffer, "hidden area",
                                       gpu::Use::Frame);
  }
  for (std::size_t eye = 0, first = 0; eye < kEyes; ++eye) {
    corners_.view<glm::vec2>(first, hidden[eye].corners.size()).copy(hidden[eye].corners);
    first += hidden[eye].corners.size();
    counts_[eye] = narrow<std::uint32_t>(hidden[eye].corners.size());
  }
}

void HiddenPass::need_pipeline() {
  if (*pipeline_) return;
  const auto drawn = gpu::push_constants<Drawn>(vk::ShaderStageFlagBits::eVertex);
  layout_ = frames_.device().logical.createPipelineLayout(
      {.pushConstantRangeCount = 1, .pPushConstantRanges = &drawn});
  pipeline_ = make_hidden_pipeline(frames_.device(), layout_, plan_, outputs_);
}

void HiddenPass::record(const vk::raii::CommandBuffer& commands, As as) const {
  if (counts_[0] + counts_[1] == 0) return;
  commands.bindPipeline(vk::PipelineBindPoint::eGraphics, *pipeline_);
  commands.bindVertexBuffers(0, *corners_.buffer().buffer, vk::DeviceSize{0});
  for (std::uint32_t eye = 0, first = 0; eye < kEyes; first += counts_[eye++]) {
    Drawn drawn = drawn_[eye];
    drawn.depth = as == As::Nearest ? 1.0f : 0.0f;
    commands.pushConstants<Drawn>(*layout_, vk::ShaderStageFlagBits::eVertex, 0, drawn);
    commands.draw(counts_[eye], 1, first, eye);
  }
}

}  // namespace farshade
