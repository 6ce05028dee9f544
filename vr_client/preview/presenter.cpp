#include "vr_client/preview/presenter.h"

#include <backends/imgui_impl_vulkan.h>
#include <imgui.h>

#include <array>
#include <cmath>
#include <stdexcept>

namespace farshade {
namespace {

using Layout = vk::ImageLayout;

/// While the device draws one frame, the next is recorded.
constexpr std::uint32_t kFlights = 2;

/// One colour attachment, cleared, that ends in `final_layout`.
vk::raii::RenderPass make_render_pass(const gpu::Device& device, vk::Format format, Layout final_layout) {
  const vk::AttachmentDescription color{.format = format,
                                        .samples = vk::SampleCountFlagBits::e1,
                                        .loadOp = vk::AttachmentLoadOp::eClear,
                                        .storeOp = vk::AttachmentStoreOp::eStore,
                                        .stencilLoadOp = vk::AttachmentLoadOp::eDontCare,
                                        .stencilStoreOp = vk::AttachmentStoreOp::eDontCare,
                                        .initialLayout = Layout::eUndefined,
                                        .finalLayout = final_layout};
  const vk::AttachmentReference reference{0, Layout::eColorAttachmentOptimal};
  const vk::SubpassDescription subpass{.pipelineBindPoint = vk::PipelineBindPoint::eGraphics,
                                       .colorAttachmentCount = 1,
                                       .pColorAttachments = &reference};
  // The image is ours from its semaphore on, which this stage waits for; afterwards it may be copied.
  using Stage = vk::PipelineStageFlagBits;
  using Access = vk::AccessFlagBits;
  const std::array dependencies{
      vk::SubpassDependency{.srcSubpass = VK_SUBPASS_EXTERNAL,
                            .dstSubpass = 0,
                            .srcStageMask = Stage::eColorAttachmentOutput,
                            .dstStageMask = Stage::eColorAttachmentOutput,
                            .dstAccessMask = Access::eColorAttachmentRead | Access::eColorAttachmentWrite},
      vk::SubpassDependency{.srcSubpass = 0,
                            .dstSubpass = VK_SUBPASS_EXTERNAL,
                            .srcStageMask = Stage::eColorAttachmentOutput,
                            .dstStageMask = Stage::eTransfer,
                            .srcAccessMask = Access::eColorAttachmentWrite,
                            .dstAccessMask = Access::eTransferRead}};
  return device.logical.createRenderPass({.attachmentCount = 1,
                                          .pAttachments = &color,
                                          .subpassCount = 1,
                                          .pSubpasses = &subpass,
                                          .dependencyCount = dependencies.size(),
                                          .pDependencies = dependencies.data()});
}

vk::raii::Framebuffer make_framebuffer(const gpu::Device& device, const vk::raii::RenderPass& pass,
                                       vk::ImageView view, Extent size) {
  return device.logical.createFramebuffer({.renderPass = *pass,
                                           .attachmentCount = 1,
                                           .pAttachments = &view,
                                           .width = size.width,
                                           .height = size.height,
                                           .layers = 1});
}

void begin(const vk::raii::CommandBuffer& commands, const vk::raii::RenderPass& pass, vk::Framebuffer target,
           Extent size) {
  const vk::ClearValue black{vk::ClearColorValue(std::array{0.0f, 0.0f, 0.0f, 1.0f})};
  commands.beginRenderPass({.renderPass = *pass,
                            .framebuffer = target,
                            .renderArea = {.extent = {size.width, size.height}},
                            .clearValueCount = 1,
                            .pClearValues = &black},
                           vk::SubpassContents::eInline);
}

/// ImGui's look: its own, as large as the desktop wants text.
void set_style(double content_scale) {
  constexpr double font_px = 13;
  ImGui::StyleColorsDark();
  ImGui::GetStyle().ScaleAllSizes(static_cast<float>(content_scale));
  ImFontConfig font;
  font.SizePixels = static_cast<float>(std::floor(font_px * content_scale));
  ImGui::GetIO().Fonts->AddFontDefault(&font);
  ImGui::GetIO().IniFilename = nullptr;  // a preview leaves no files behind
}

}  // namespace

PanelContext::PanelContext(const gpu::Device& device, Window& window, const vk::raii::RenderPass& render_pass)
    : window_(window) {
  ImGui::CreateContext();
  set_style(window.content_scale());
  window.attach_panel();
  const vk::DescriptorPoolSize font{.type = vk::DescriptorType::eCombinedImageSampler, .descriptorCount = 1};
  pool_ = device.logical.createDescriptorPool({.flags = vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet,
                                               .maxSets = 1,
                                               .poolSizeCount = 1,
                                               .pPoolSizes = &font});
  ImGui_ImplVulkan_InitInfo info{};
  info.Instance = *device.instance;
  info.PhysicalDevice = *device.physical;
  info.Device = *device.logical;
  info.QueueFamily = device.queue_family;
  info.Queue = *device.queue;
  info.DescriptorPool = *pool_;
  info.MinImageCount = kFlights;
  info.ImageCount = kFlights;
  info.MSAASamples = VK_SAMPLE_COUNT_1_BIT;
  info.CheckVkResultFn = [](VkResult result) {
    if (result < 0) throw std::runtime_error("ImGui's Vulkan back end: " + vk::to_string(vk::Result(result)));
  };
  ImGui_ImplVulkan_Init(&info, *render_pass);
  gpu::run_now(device, [](const vk::raii::CommandBuffer& commands) {
    ImGui_ImplVulkan_CreateFontsTexture(*commands);
  });
  ImGui_ImplVulkan_DestroyFontUploadObjects();
}

PanelContext::~PanelContext() {
  ImGui_ImplVulkan_Shutdown();
  window_.detach_panel();
  ImGui::DestroyContext();
}

void PanelContext::lay_out(const std::function<void()>& draw) {
  ImGui_ImplVulkan_NewFrame();
  window_.begin_panel();
  ImGui::NewFrame();
  draw();
  ImGui::Render();
}

void PanelContext::record(const vk::raii::CommandBuffer& commands) const {
  ImGui_ImplVulkan_RenderDrawData(ImGui::GetDrawData(), *commands);
}

Presenter::Presenter(const gpu::Device& device, Window& window, const gpu::Image& eyes)
    : device_(device),
      window_(window),
      surface_(window.make_surface(device.instance)),
      swapchain_(device, surface_),
      render_pass_(make_render_pass(device, swapchain_.format(), Layout::ePresentSrcKHR)),
      compose_(device, eyes, render_pass_),
      panel_(device, window, render_pass_) {
  auto commands = device.logical.allocateCommandBuffers({.commandPool = *device.commands,
                                                         .level = vk::CommandBufferLevel::ePrimary,
                                                         .commandBufferCount = kFlights});
  for (auto& buffer : commands)
    flights_.push_back({std::move(buffer),
                        device.logical.createFence({.flags = vk::FenceCreateFlagBits::eSignaled}),
                        device.logical.createSemaphore({})});
}

Presenter::~Presenter() {
  try {
    device_.logical.waitIdle();
  } catch (const vk::SystemError&) {
    // A lost device draws no more, and who lost it has been told.
  }
}

void Presenter::fit_to_window() {
  if (!swapchain_.fit(window_.framebuffer_size())) return;
  framebuffers_.clear();
  drawn_.clear();
  for (const vk::raii::ImageView& view : swapchain_.views()) {
    framebuffers_.push_back(make_framebuffer(device_, render_pass_, *view, swapchain_.size()));
    drawn_.push_back(device_.logical.createSemaphore({}));
  }
}

Presenter::Outcome Presenter::show(const Composition& composition, const std::function<void()>& draw_panel) {
  fit_to_window();
  if (swapchain_.size().pixels() == 0) return Outcome::NotNow;
  const Flight& flight = flights_[next_flight_];
  if (device_.logical.waitForFences(*flight.done, true, gpu::kGpuTimeout_ns) != vk::Result::eSuccess)
    throw std::runtime_error("vkWaitForFences: the device did not finish within 30 s");
  const auto image = swapchain_.acquire(*flight.image_ready);
  if (!image) return Outcome::NotNow;
  panel_.lay_out(draw_panel);
  record(flight, composition, *framebuffers_[*image]);
  const vk::PipelineStageFlags at = vk::PipelineStageFlagBits::eColorAttachmentOutput;
  device_.logical.resetFences(*flight.done);
  device_.queue.submit(vk::SubmitInfo{.waitSemaphoreCount = 1,
                                      .pWaitSemaphores = &*flight.image_ready,
                                      .pWaitDstStageMask = &at,
                                      .commandBufferCount = 1,
                                      .pCommandBuffers = &*flight.commands,
                                      .signalSemaphoreCount = 1,
                                      .pSignalSemaphores = &*drawn_[*image]},
                       *flight.done);
  swapchain_.present(*image, *drawn_[*image]);
  next_flight_ = (next_flight_ + 1) % flights_.size();
  return Outcome::Shown;
}

void Presenter::record(const Flight& flight, const Composition& composition, vk::Framebuffer target) const {
  flight.commands.reset();
  flight.commands.begin({.flags = vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
  compose_.record_barrier(flight.commands);
  begin(flight.commands, render_pass_, target, swapchain_.size());
  compose_.record(flight.commands, composition, swapchain_.size());
  panel_.record(flight.commands);
  flight.commands.endRenderPass();
  flight.commands.end();
}

Image<Rgb8> Presenter::read_back(const Composition& composition) const {
  const Extent size = window_.framebuffer_size();
  if (size.pixels() == 0) return {};
  using Usage = vk::ImageUsageFlagBits;
  const gpu::Image target = gpu::make_image(
      device_,
      {.size = size, .format = swapchain_.format(), .usage = Usage::eColorAttachment | Usage::eTransferSrc},
      "composed");
  const vk::raii::RenderPass pass =
      make_render_pass(device_, swapchain_.format(), Layout::eTransferSrcOptimal);
  const vk::raii::ImageView view =
      device_.logical.createImageView({.image = *target.image,
                                       .viewType = vk::ImageViewType::e2D,
                                       .format = swapchain_.format(),
                                       .subresourceRange = {vk::ImageAspectFlagBits::eColor, 0, 1, 0, 1}});
  const vk::raii::Framebuffer framebuffer = make_framebuffer(device_, pass, *view, size);
  const gpu::Buffer pixels = gpu::make_readback_buffer(device_, size.pixels() * 4, "composed read-back");
  gpu::run_now(device_, [&](const vk::raii::CommandBuffer& commands) {
    compose_.record_barrier(commands);
    begin(commands, pass, *framebuffer, size);
    compose_.record(commands, composition, size);
    commands.endRenderPass();
    commands.copyImageToBuffer(
        *target.image, Layout::eTransferSrcOptimal, *pixels.buffer,
        vk::BufferImageCopy{.imageSubresource = {vk::ImageAspectFlagBits::eColor, 0, 0, 1},
                            .imageExtent = {size.width, size.height, 1}});
  });
  Image<Rgb8> result(size);
  const bool blue_first = swapchain_.format() == vk::Format::eB8G8R8A8Unorm;
  for (std::size_t i = 0; i < size.pixels(); ++i) {
    const Rgba8 pixel = pixels.as<const Rgba8>()[i];
    result.pixels[i] = blue_first ? Rgb8(pixel.z, pixel.y, pixel.x) : Rgb8(pixel);
  }
  return result;
}

}  // namespace farshade
