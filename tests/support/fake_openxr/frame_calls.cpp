// The calls of a frame. Calls in a wrong order are refused and noted as misuses.
#include "tests/support/fake_openxr/runtime.h"

namespace farshade::fake_openxr {
namespace {

using OfFrame = SessionParts::Frame;
using OfImage = SwapchainParts::Image;

XrResult out_of_order(std::string what) {
  return misuse(XR_ERROR_CALL_ORDER_INVALID, std::move(what));
}

XrResult wait_frame(XrSession session, const XrFrameWaitInfo*, XrFrameState* frame) {
  const Runtime& script = state().script;
  SessionParts& parts = state().sessions.at(session);
  if (!parts.is_running)
    return misuse(XR_ERROR_SESSION_NOT_RUNNING, "xrWaitFrame of a session that does not run");
  if (parts.frame == OfFrame::Waited) return out_of_order("xrWaitFrame twice without xrBeginFrame");
  if (parts.frame == OfFrame::Begun) return out_of_order("xrWaitFrame before xrEndFrame");
  parts.frame = OfFrame::Waited;
  parts.time = parts.time == 0 ? script.first_time : parts.time + script.period;
  frame->predictedDisplayTime = parts.time;
  frame->predictedDisplayPeriod = script.period;
  frame->shouldRender = !script.frame || script.frame(parts.time).should_render;
  return XR_SUCCESS;
}

XrResult begin_frame(XrSession session, const XrFrameBeginInfo*) {
  SessionParts& parts = state().sessions.at(session);
  if (parts.frame != OfFrame::Waited) return out_of_order("xrBeginFrame without xrWaitFrame");
  parts.frame = OfFrame::Begun;
  return XR_SUCCESS;
}

XrResult locate_views(XrSession session, const XrViewLocateInfo* info, XrViewState* view_state,
                      std::uint32_t capacity, std::uint32_t* count, XrView* views) {
  const Runtime& script = state().script;
  if (info->viewConfigurationType != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO)
    return XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED;
  if (!state().spaces.contains(info->space))
    return misuse(XR_ERROR_HANDLE_INVALID, "xrLocateViews in no space");
  if (info->displayTime != state().sessions.at(session).time)
    return misuse(XR_ERROR_TIME_INVALID, "xrLocateViews at another time than that of the frame");
  const Frame frame = script.frame ? script.frame(info->displayTime) : Frame{};
  view_state->viewStateFlags =
      frame.is_tracked ? XR_VIEW_STATE_ORIENTATION_VALID_BIT | XR_VIEW_STATE_POSITION_VALID_BIT : 0;
  std::vector<XrView> all;
  for (const View& view : frame.views) all.push_back({XR_TYPE_VIEW, nullptr, view.pose, view.fov});
  return enumerate<XrView>(all, capacity, count, views);
}

XrResult acquire_image(XrSwapchain swapchain, const XrSwapchainImageAcquireInfo*, std::uint32_t* index) {
  SwapchainParts& parts = state().swapchains.at(swapchain);
  if (parts.image != OfImage::None) return out_of_order("xrAcquireSwapchainImage of a second image");
  parts.image = OfImage::Acquired;
  *index = parts.next + state().script.first_image;
  parts.next = (parts.next + 1) % static_cast<std::uint32_t>(parts.images.size());
  return XR_SUCCESS;
}

XrResult wait_image(XrSwapchain swapchain, const XrSwapchainImageWaitInfo*) {
  SwapchainParts& parts = state().swapchains.at(swapchain);
  if (parts.image != OfImage::Acquired)
    return out_of_order("xrWaitSwapchainImage of an image that was not acquired");
  parts.image = OfImage::Waited;
  return XR_SUCCESS;
}

XrResult release_image(XrSwapchain swapchain, const XrSwapchainImageReleaseInfo*) {
  SwapchainParts& parts = state().swapchains.at(swapchain);
  if (parts.image != OfImage::Waited)
    return out_of_order("xrReleaseSwapchainImage of an image that was not waited for");
  parts.image = OfImage::None;
  parts.has_content = true;
  return XR_SUCCESS;
}

/// Checks and notes an image that a layer shows.
XrResult check_shown(const XrSwapchainSubImage& shown) {
  const auto found = state().swapchains.find(shown.swapchain);
  if (found == state().swapchains.end()) return misuse(XR_ERROR_HANDLE_INVALID, "a layer of no swapchain");
  if (!found->second.has_content || found->second.image != OfImage::None)
    return misuse(XR_ERROR_LAYER_INVALID, "a layer of an image that was not released");
  return XR_SUCCESS;
}

XrResult note_view(const XrCompositionLayerProjectionView& view, SubmittedFrame& frame) {
  SubmittedView submitted{view.pose, view.fov, view.subImage, std::nullopt};
  if (const XrResult result = check_shown(view.subImage); XR_FAILED(result)) return result;
  for (const auto* next = static_cast<const XrBaseInStructure*>(view.next); next; next = next->next) {
    if (next->type != XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR) continue;
    if (!is_enabled(XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME))
      return misuse(XR_ERROR_VALIDATION_FAILURE, "a depth without XR_KHR_composition_layer_depth");
    submitted.depth = *reinterpret_cast<const XrCompositionLayerDepthInfoKHR*>(next);
    if (const XrResult result = check_shown(submitted.depth->subImage); XR_FAILED(result)) return result;
  }
  frame.views.push_back(submitted);
  return XR_SUCCESS;
}

XrResult end_frame(XrSession session, const XrFrameEndInfo* info) {
  SessionParts& parts = state().sessions.at(session);
  if (parts.frame != OfFrame::Begun) return out_of_order("xrEndFrame without xrBeginFrame");
  parts.frame = OfFrame::None;
  if (info->displayTime != parts.time)
    return misuse(XR_ERROR_TIME_INVALID, "xrEndFrame at another time than that of the frame");
  SubmittedFrame frame{.time = info->displayTime, .views = {}};
  for (const XrCompositionLayerBaseHeader* layer : std::span(info->layers, info->layerCount)) {
    if (layer->type != XR_TYPE_COMPOSITION_LAYER_PROJECTION)
      return misuse(XR_ERROR_LAYER_INVALID, "a layer that is no projection");
    const auto& projection = *reinterpret_cast<const XrCompositionLayerProjection*>(layer);
    if (!state().spaces.contains(projection.space))
      return misuse(XR_ERROR_HANDLE_INVALID, "a layer in no space");
    for (const auto& view : std::span(projection.views, projection.viewCount))
      if (const XrResult result = note_view(view, frame); XR_FAILED(result)) return result;
  }
  state().script.frames.push_back(std::move(frame));
  return XR_SUCCESS;
}

}  // namespace

std::vector<Function> frame_calls() {
  return {entry<"xrWaitFrame", &wait_frame>(),
          entry<"xrBeginFrame", &begin_frame>(),
          entry<"xrLocateViews", &locate_views>(),
          entry<"xrAcquireSwapchainImage", &acquire_image>(),
          entry<"xrWaitSwapchainImage", &wait_image>(),
          entry<"xrReleaseSwapchainImage", &release_image>(),
          entry<"xrEndFrame", &end_frame>()};
}

}  // namespace farshade::fake_openxr
