#include "vr_client/preview/panel_layer.h"

#include <backends/imgui_impl_vulkan.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <stdexcept>

namespace farshade {
namespace {

using Layout = vk::ImageLayout;

constexpr Duration kRedrawInterval = std::chrono::milliseconds(100);

/// Number of frames for which ImGui keeps buffers: the device draws one while the next is recorded.
constexpr std::uint32_t kDrawings = 2;

/// One colour attachment that is cleared first and copied afterwards. ImGui 1.86 does not support dynamic
/// rendering.
vk::raii::RenderPass make_render_pass(const gpu::Device& device, vk::Format format) {
  const vk::AttachmentDescription color{.format = format,
                                        .samples = vk::SampleCountFlagBits::e1,
                                        .loadOp = vk::AttachmentLoadOp::eClear,
                                        .storeOp = vk::AttachmentStoreOp::eStore,
                                        .stencilLoadOp = vk::AttachmentLoadOp::eDontCare,
                                        .stencilStoreOp = vk::AttachmentStoreOp::eDontCare,
                                        .initialLayout = Layout::eUndefined,
                                        .finalLayout = Layout::eTransferSrcOptimal};
  const vk::AttachmentReference reference{0, Layout::eColorAttachmentOptimal};
  const vk::SubpassDescription subpass{.pipelineBindPoint = vk::PipelineBindPoint::eGraphics,
                                       .colorAttachmentCount = 1,
                                       .pColorAttachments = &reference};
  using Stage = vk::PipelineStageFlagBits;
  using Access = vk::AccessFlagBits;
  const std::array dependencies{
      vk::SubpassDependency{.srcSubpass = VK_SUBPASS_EXTERNAL,
                            .dstSubpass = 0,
                            .srcStageMask = Stage::eTransfer,
                            .dstStageMask = Stage::eColorAttachmentOutput,
                            .srcAccessMask = Access::eTransferRead,
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

/// One font for each scale of text.
void add_fonts() {
  constexpr int font_px = 13;
  for (int half_steps = 2 * kSmallestText; half_steps <= 2 * kLargestText; ++half_steps) {
    const int size_px = font_px * half_steps / 2;
    ImFontConfig font;
    font.SizePixels = static_cast<float>(size_px);
    ImGui::GetIO().Fonts->AddFontDefault(&font);
  }
}

/// ImGui's dark style with text of a scale. Windows have square corners, no transparency and no border, so
/// that each fills exactly its rectangle.
void set_style(double scale) {
  ImGuiStyle& style = ImGui::GetStyle();
  style = ImGuiStyle();
  ImGui::StyleColorsDark();
  style.WindowRounding = style.PopupRounding = style.ChildRounding = 0;
  style.WindowBorderSize = style.PopupBorderSize = 0;
  for (const ImGuiCol color : {ImGuiCol_WindowBg, ImGuiCol_PopupBg, ImGuiCol_TitleBg, ImGuiCol_TitleBgActive,
                               ImGuiCol_TitleBgCollapsed})
    style.Colors[color].w = 1;
  style.ScaleAllSizes(static_cast<float>(scale));
  ImGuiIO& io = ImGui::GetIO();
  io.FontDefault = io.Fonts->Fonts[static_cast<int>(2 * scale) - 2 * kSmallestText];
}

void init_back_end(const gpu::Device& device, vk::DescriptorPool pool, vk::RenderPass render_pass) {
  ImGui_ImplVulkan_InitInfo info{};
  info.Instance = *device.instance;
  info.PhysicalDevice = *device.physical;
  info.Device = *device.logical;
  info.QueueFamily = device.queue_family;
  info.Queue = *device.queue;
  info.DescriptorPool = pool;
  info.MinImageCount = kDrawings;
  info.ImageCount = kDrawings;
  info.MSAASamples = VK_SAMPLE_COUNT_1_BIT;
  info.CheckVkResultFn = [](VkResult result) {
    if (result < 0) throw std::runtime_error("ImGui's Vulkan back end: " + vk::to_string(vk::Result(result)));
  };
  ImGui_ImplVulkan_Init(&info, render_pass);
#if IMGUI_VERSION_NUM >= 19000  // Debian 13
  ImGui_ImplVulkan_CreateFontsTexture();
#else  // Debian 12
  gpu::run_now(device, [](const vk::raii::CommandBuffer& commands) {
    ImGui_ImplVulkan_CreateFontsTexture(*commands);
  });
  ImGui_ImplVulkan_DestroyFontUploadObjects();
#endif
}

/// The bounding rectangle of an ImGui draw list.
std::optional<vk::Rect2D> covered(const ImDrawList& list, Extent within) {
  glm::dvec2 low(within.width, within.height), high(0, 0);
  for (const ImDrawVert& vertex : list.VtxBuffer) {
    if ((vertex.col & IM_COL32_A_MASK) == 0) continue;  // the transparent side of an anti-aliased edge
    low = glm::min(low, glm::dvec2(vertex.pos.x, vertex.pos.y));
    high = glm::max(high, glm::dvec2(vertex.pos.x, vertex.pos.y));
  }
  low = glm::max(glm::floor(low), 0.0);
  high = glm::min(glm::ceil(high), glm::dvec2(within.width, within.height));
  if (low.x >= high.x || low.y >= high.y) return std::nullopt;
  return vk::Rect2D{{static_cast<std::int32_t>(low.x), static_cast<std::int32_t>(low.y)},
                    {static_cast<std::uint32_t>(high.x - low.x), static_cast<std::uint32_t>(high.y - low.y)}};
}

bool contains(const vk::Rect2D& rect, glm::dvec2 point) {
  return point.x >= rect.offset.x && point.x < rect.offset.x + static_cast<double>(rect.extent.width) &&
         point.y >= rect.offset.y && point.y < rect.offset.y + static_cast<double>(rect.extent.height);
}

}  // namespace

PanelLayer::PanelLayer(const gpu::Device& device, Window& window, vk::Format format)
    : device_(device), window_(window), format_(format), render_pass_(make_render_pass(device, format)) {
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;  // write no settings file
  add_fonts();
  window.attach_panel([this](glm::dvec2 place) { return covers(place); });
  const vk::DescriptorPoolSize font{.type = vk::DescriptorType::eCombinedImageSampler, .descriptorCount = 1};
  pool_ = device.logical.createDescriptorPool({.flags = vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet,
                                               .maxSets = 1,
                                               .poolSizeCount = 1,
                                               .pPoolSizes = &font});
  init_back_end(device, *pool_, *render_pass_);
}

PanelLayer::~PanelLayer() {
  ImGui_ImplVulkan_Shutdown();
  window_.detach_panel();
  ImGui::DestroyContext();
}

bool PanelLayer::is_due(Extent window, Time now) const {
  if (!laid_out_ || now - *laid_out_ >= kRedrawInterval || image_.spec.size != window) return true;
  if (ImGui::IsAnyItemActive()) return true;
  return covers(window_.cursor_px());
}

bool PanelLayer::covers(glm::dvec2 place) const {
  return std::ranges::any_of(windows_, [&](const vk::Rect2D& rect) { return contains(rect, place); });
}

void PanelLayer::lay_out(Extent window, Time now, const std::function<void()>& draw) {
  if (image_.spec.size != window) fit(window);
  laid_out_ = now;
  follow_text_scale();
  ImGui_ImplVulkan_NewFrame();
  window_.begin_panel();
  ImGui::NewFrame();
  draw();
  ImGui::Render();
  const ImDrawData& data = *ImGui::GetDrawData();
  windows_.clear();
  for (int i = 0; i < data.CmdListsCount; ++i)
    if (const auto rect = covered(*data.CmdLists[i], window)) windows_.push_back(*rect);
}

void PanelLayer::follow_text_scale() {
  const double scale = window_.text_scale();
  if (scale == text_scale_) return;
  text_scale_ = scale;
  set_style(scale);
}

void PanelLayer::fit(Extent window) {
  using Usage = vk::ImageUsageFlagBits;
  device_.logical.waitIdle();  // a frame in flight may copy from the image
  image_ = gpu::make_image(
      device_, {.size = window, .format = format_, .usage = Usage::eColorAttachment | Usage::eTransferSrc},
      "panel");
  const vk::ImageView view = *image_.view;
  framebuffer_ = device_.logical.createFramebuffer({.renderPass = *render_pass_,
                                                    .attachmentCount = 1,
                                                    .pAttachments = &view,
                                                    .width = window.width,
                                                    .height = window.height,
                                                    .layers = 1});
}

void PanelLayer::record_drawing(const vk::raii::CommandBuffer& commands) {
  const vk::ClearValue nothing{};
  commands.beginRenderPass({.renderPass = *render_pass_,
                            .framebuffer = *framebuffer_,
                            .renderArea = {.extent = {image_.spec.size.width, image_.spec.size.height}},
                            .clearValueCount = 1,
                            .pClearValues = &nothing},
                           vk::SubpassContents::eInline);
  ImGui_ImplVulkan_RenderDrawData(ImGui::GetDrawData(), *commands);
  commands.endRenderPass();
}

void PanelLayer::record_copy(const vk::raii::CommandBuffer& commands, vk::Image target) const {
  for (const vk::Rect2D& rect : windows_) {
    const vk::ImageSubresourceLayers layer{vk::ImageAspectFlagBits::eColor, 0, 0, 1};
    const vk::Offset3D at{rect.offset.x, rect.offset.y, 0};
    commands.copyImage(*image_.image, Layout::eTransferSrcOptimal, target, Layout::eTransferDstOptimal,
                       vk::ImageCopy{.srcSubresource = layer,
                                     .srcOffset = at,
                                     .dstSubresource = layer,
                                     .dstOffset = at,
                                     .extent = {rect.extent.width, rect.extent.height, 1}});
  }
}

}  // namespace farshade
