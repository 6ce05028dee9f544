#include "stereo/reproject/timewarp_pass.h"

#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>

#include "shaders/timewarp.comp.spv.h"
#include "shaders/timewarp_data.h"

namespace farshade {
namespace {

/// From eye-space (x, y, z), z < 0, to homogeneous pixels: ray_pixel of fov.h as a matrix.
glm::dmat3 pixel_from_ray(const View& view) {
  const FovTangents tangents = tangents_of(view.fov);
  const double per_x = view.size.width / (tangents.right_tan - tangents.left_tan),
               per_y = view.size.height / (tangents.down_tan - tangents.up_tan);
  return {{per_x, 0, 0}, {0, per_y, 0}, {tangents.left_tan * per_x, tangents.up_tan * per_y, -1}};
}

/// From homogeneous pixels to the eye-space point on z = -1: pixel_ray of fov.h as a matrix.
glm::dmat3 ray_from_pixel(const View& view) {
  const FovTangents tangents = tangents_of(view.fov);
  const double step_x = (tangents.right_tan - tangents.left_tan) / view.size.width,
               step_y = (tangents.down_tan - tangents.up_tan) / view.size.height;
  return {{step_x, 0, 0}, {0, step_y, 0}, {tangents.left_tan, tangents.up_tan, -1}};
}

/// Linear light of the 256 levels of sRGB (IEC 61966-2-1).
std::array<float, 256> light_of_levels() {
  std::array<float, 256> light{};
  for (std::size_t level = 0; level < light.size(); ++level) {
    const double c = static_cast<double>(level) / 255;
    light[level] = static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
  }
  return light;
}

/// Makes all earlier writes visible to all later commands and to the host.
void barrier(const vk::raii::CommandBuffer& commands) {
  const vk::MemoryBarrier2 memory{
      .srcStageMask = vk::PipelineStageFlagBits2::eAllCommands,
      .srcAccessMask = vk::AccessFlagBits2::eMemoryWrite,
      .dstStageMask = vk::PipelineStageFlagBits2::eAllCommands | vk::PipelineStageFlagBits2::eHost,
      .dstAccessMask = vk::AccessFlagBits2::eMemoryRead | vk::AccessFlagBits2::eMemoryWrite |
                       vk::AccessFlagBits2::eHostRead};
  commands.pipelineBarrier2({.memoryBarrierCount = 1, .pMemoryBarriers = &memory});
}

}  // namespace

glm::dmat3 timewarped_pixel(const View& from, const View& shown) {
  const glm::dquat from_shown =
      glm::normalize(glm::conjugate(from.stage_from_eye.rotation) * shown.stage_from_eye.rotation);
  return pixel_from_ray(from) * glm::mat3_cast(from_shown) * ray_from_pixel(shown);
}

PerEye<double> outside_share(const StereoView& from, const StereoView& shown) {
  PerEye<double> shares{};
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const glm::dmat3 from_shown = timewarped_pixel(from[eye], shown[eye]);
    const auto [width, height] = from[eye].size;
    std::size_t outside = 0;
    for (std::uint32_t y = 0; y < shown[eye].size.height; ++y)
      for (std::uint32_t x = 0; x < shown[eye].size.width; ++x) {
        const glm::dvec3 at = from_shown * glm::dvec3(x + 0.5, y + 0.5, 1.0);
        outside += !(at.z > 0 && at.x >= 0 && at.x <= width * at.z && at.y >= 0 && at.y <= height * at.z);
      }
    shares[eye] = static_cast<double>(outside) / static_cast<double>(shown[eye].size.pixels());
  }
  return shares;
}

TimewarpPass::TimewarpPass(gpu::FramesInFlight& frames, const gpu::Image& shown, Extent largest)
    : device_(frames.device()),
      shown_(shown),
      size_(shown.spec.size),
      largest_(largest),
      picture_(gpu::make_upload_buffer(
          frames, kEyes * largest.pixels() * 4,
          vk::BufferUsageFlagBits::eStorageBuffer | vk::BufferUsageFlagBits::eTransferDst, "picture to turn",
          gpu::Use::Shown)),
      light_of_(gpu::make_upload_buffer(frames, 256 * sizeof(float), vk::BufferUsageFlagBits::eStorageBuffer,
                                        "light of levels", gpu::Use::Shown)),
      bindings_(gpu::make_bindings(device_,
                                   {{vk::DescriptorType::eStorageBuffer, vk::ShaderStageFlagBits::eCompute},
                                    {vk::DescriptorType::eStorageImage, vk::ShaderStageFlagBits::eCompute},
                                    {vk::DescriptorType::eStorageBuffer, vk::ShaderStageFlagBits::eCompute}},
                                   "timewarp")) {
  gpu::bind_buffer(device_, bindings_, 0, picture_.buffer());
  gpu::bind_image(device_, bindings_, 1, {*shown.view, vk::ImageLayout::eGeneral, nullptr});
  gpu::bind_buffer(device_, bindings_, 2, light_of_.buffer());
  light_of_.view<float>().copy(light_of_levels());
  const auto push = gpu::push_constants<gpu::TimewarpData>(vk::ShaderStageFlagBits::eCompute);
  layout_ = device_.logical.createPipelineLayout({.setLayoutCount = 1,
                                                  .pSetLayouts = &*bindings_.layout,
                                                  .pushConstantRangeCount = 1,
                                                  .pPushConstantRanges = &push});
}

void TimewarpPass::load(const PerEye<Image<Rgb8>>& picture) {
  loaded_ = picture[0].size;
  check(picture[1].size == loaded_ && loaded_.width <= largest_.width && loaded_.height <= largest_.height,
        "a picture to turn has room");
  const std::size_t pixels = loaded_.pixels();
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    picture_.view<Rgba8>(eye * pixels, pixels).generate([from = picture[eye].pixels.data()](std::size_t i) {
      return Rgba8(from[i], 255);
    });
}

const vk::raii::Pipeline& TimewarpPass::need_pipeline(Effect effect) {
  vk::raii::Pipeline& pipeline = pipelines_[static_cast<std::size_t>(effect)];
  if (*pipeline) return pipeline;
  std::vector<std::uint32_t> constants(1);
  constants[FARSHADE_TIMEWARP_CONSTANT_ADDS] = effect == Effect::Add;
  pipeline = gpu::make_compute_pipeline(device_, layout_, timewarp_comp_spv, constants, "timewarp");
  return pipeline;
}

void TimewarpPass::copy_shown(const vk::raii::CommandBuffer& commands) const {
  constexpr auto rest = vk::ImageLayout::eGeneral, source = vk::ImageLayout::eTransferSrcOptimal;
  gpu::transition(commands, shown_, rest, source);
  commands.copyImageToBuffer(
      *shown_.image, source, *picture_.buffer().buffer,
      vk::BufferImageCopy{.imageSubresource = {shown_.aspect, 0, 0, narrow<std::uint32_t>(kEyes)},
                          .imageExtent = {size_.width, size_.height, 1}});
  gpu::transition(commands, shown_, source, rest);
  barrier(commands);
}

void TimewarpPass::record(const vk::raii::CommandBuffer& commands, const StereoView& from,
                          const StereoView& shown, Source source, Effect effect) {
  const Extent picture = source == Source::Shown ? size_ : loaded_;
  gpu::TimewarpData data{.from_shown = {},
                         .size = {size_.width, size_.height, picture.width, picture.height}};
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    check(from[eye].size == picture && shown[eye].size == size_, "views have the size of their pictures");
    const glm::dmat3 from_shown = timewarped_pixel(from[eye], shown[eye]);
    for (int column = 0; column < 3; ++column)
      data.from_shown[eye * 3 + static_cast<std::size_t>(column)] = glm::vec4(from_shown[column], 0.0);
  }
  gpu::record_uploads(commands, {&picture_, &light_of_});
  barrier(commands);
  if (source == Source::Shown) copy_shown(commands);
  commands.bindPipeline(vk::PipelineBindPoint::eCompute, *need_pipeline(effect));
  commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *layout_, 0, *bindings_.set, {});
  commands.pushConstants<gpu::TimewarpData>(*layout_, vk::ShaderStageFlagBits::eCompute, 0, data);
  commands.dispatch((size_.width + FARSHADE_TIMEWARP_GROUP - 1) / FARSHADE_TIMEWARP_GROUP, size_.height,
                    kEyes);
  barrier(commands);
}

std::size_t TimewarpPass::pipelines() const {
  return std::size_t{*pipelines_[0] ? 1u : 0u} + std::size_t{*pipelines_[1] ? 1u : 0u};
}

}  // namespace farshade
