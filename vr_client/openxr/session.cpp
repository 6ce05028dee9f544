#include "vr_client/openxr/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "vr_client/openxr/pose.h"

namespace farshade::openxr {
namespace {

/// Formats whose bytes are those of the shown picture, which is coded as sRGB. The compositor decodes them.
constexpr std::array kFormats{vk::Format::eR8G8B8A8Srgb, vk::Format::eA8B8G8R8SrgbPack32};

/// The format of the renderer's depth.
constexpr vk::Format kDepthFormat = vk::Format::eD32Sfloat;

/// A compositor that holds all images for longer has stopped.
constexpr XrDuration kImageTimeout_ns = 2'000'000'000;

XrPosef pose(const Rigid<Tracked, Eye>& from) {
  const glm::quat q(from.rotation);
  const glm::vec3 p(from.translation);
  return {{q.x, q.y, q.z, q.w}, {p.x, p.y, p.z}};
}

EyeFov fov_of(const XrFovf& fov) {
  return {fov.angleLeft, fov.angleRight, fov.angleUp, fov.angleDown};
}

XrFovf fov_of(const EyeFov& fov) {
  return {static_cast<float>(fov.left_rad), static_cast<float>(fov.right_rad), static_cast<float>(fov.up_rad),
          static_cast<float>(fov.down_rad)};
}

/// The formats that the runtime offers, by its preference.
Expected<std::vector<vk::Format>> offered_formats(XrSession session) {
  std::uint32_t count = 0;
  XrResult result = xrEnumerateSwapchainFormats(session, 0, &count, nullptr);
  std::vector<std::int64_t> offered(count);
  if (XR_SUCCEEDED(result)) result = xrEnumerateSwapchainFormats(session, count, &count, offered.data());
  if (auto done = succeeded(result, "xrEnumerateSwapchainFormats"); !done)
    return tl::unexpected(done.error());
  std::vector<vk::Format> formats;
  for (const std::int64_t format : offered) formats.push_back(static_cast<vk::Format>(format));
  return formats;
}

}  // namespace

bool is_rate(float refresh_hz) {
  return refresh_hz > 0 && refresh_hz <= 1000;  // false for NaN
}

Expected<std::unique_ptr<Session>> Session::open(const Instance& instance, const gpu::Device& device,
                                                 Extent size) {
  std::unique_ptr<Session> session(new Session(instance, size));
  Expected<void> done = session->create(device);
  if (done) done = session->create_space();
  if (done) done = session->create_swapchains();
  if (!done) return tl::unexpected(done.error());
  return session;
}

Expected<void> Session::create(const gpu::Device& device) {
  const XrGraphicsBindingVulkanKHR graphics{XR_TYPE_GRAPHICS_BINDING_VULKAN_KHR,
                                            nullptr,
                                            *device.instance,
                                            *device.physical,
                                            *device.logical,
                                            device.queue_family,
                                            0};
  const XrSessionCreateInfo info{XR_TYPE_SESSION_CREATE_INFO, &graphics, 0, instance_.system()};
  return succeeded(xrCreateSession(instance_.handle(), &info, &handle_), "xrCreateSession");
}

Expected<void> Session::create_space() {
  XrReferenceSpaceCreateInfo info{XR_TYPE_REFERENCE_SPACE_CREATE_INFO, nullptr, XR_REFERENCE_SPACE_TYPE_STAGE,
                                  kOrigin};
  XrResult result = xrCreateReferenceSpace(handle_, &info, &space_);
  if (result == XR_ERROR_REFERENCE_SPACE_UNSUPPORTED) {
    info.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
    result = xrCreateReferenceSpace(handle_, &info, &space_);
  }
  space_type_ = info.referenceSpaceType;
  return succeeded(result, "xrCreateReferenceSpace");
}

Expected<void> Session::create_swapchains() {
  const Expected<std::vector<vk::Format>> offered = offered_formats(handle_);
  if (!offered) return tl::unexpected(offered.error());
  const auto is_offered = [&](vk::Format format) {
    return std::ranges::find(*offered, format) != offered->end();
  };
  const auto* const format = std::ranges::find_if(kFormats, is_offered);
  if (format == kFormats.end()) {
    std::string names;
    for (const vk::Format one : *offered) names += (names.empty() ? "" : ", ") + vk::to_string(one);
    return fail(
        Fault::Unsupported,
        "the OpenXR runtime offers no 8-bit RGBA sRGB swapchain, which this client needs, only " + names);
  }
  pictures_.format = *format;
  if (auto done = fill(pictures_, XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT); !done) return done;
  if (!instance_.extensions().depth_layers || !is_offered(kDepthFormat)) return {};
  depths_.format = kDepthFormat;
  return fill(depths_, XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
}

Expected<void> Session::fill(Swapchain& swapchain, XrSwapchainUsageFlags usage) const {
  const XrSwapchainCreateInfo info{XR_TYPE_SWAPCHAIN_CREATE_INFO,
                                   nullptr,
                                   0,
                                   usage | XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT,
                                   static_cast<std::int64_t>(swapchain.format),
                                   1,
                                   size_.width,
                                   size_.height,
                                   1,
                                   static_cast<std::uint32_t>(kEyes),
                                   1};
  if (auto done = succeeded(xrCreateSwapchain(handle_, &info, &swapchain.handle), "xrCreateSwapchain"); !done)
    return done;
  std::uint32_t count = 0;
  XrResult result = xrEnumerateSwapchainImages(swapchain.handle, 0, &count, nullptr);
  swapchain.images.assign(count, {XR_TYPE_SWAPCHAIN_IMAGE_VULKAN_KHR, nullptr, VK_NULL_HANDLE});
  if (XR_SUCCEEDED(result))
    result =
        xrEnumerateSwapchainImages(swapchain.handle, count, &count,
                                   reinterpret_cast<XrSwapchainImageBaseHeader*>(swapchain.images.data()));
  return succeeded(result, "xrEnumerateSwapchainImages");
}

/// The session's space and swapchains end with it.
Session::~Session() {
  if (handle_ != XR_NULL_HANDLE) xrDestroySession(handle_);
}

std::optional<double> Session::refresh_hz() const {
  if (!instance_.extensions().refresh_rate) return std::nullopt;
  float rate = 0;
  const XrResult result =
      call<PFN_xrGetDisplayRefreshRateFB>(instance_.handle(), "xrGetDisplayRefreshRateFB", handle_, &rate);
  if (XR_FAILED(result) || !is_rate(rate)) return std::nullopt;
  return rate;
}

XrResult Session::begin() {
  const XrSessionBeginInfo info{XR_TYPE_SESSION_BEGIN_INFO, nullptr, kViews};
  return xrBeginSession(handle_, &info);
}

XrResult Session::end() {
  return xrEndSession(handle_);
}

XrResult Session::request_exit() {
  return xrRequestExitSession(handle_);
}

XrResult Session::wait_frame(XrSession session, XrFrameState& state) {
  state = {XR_TYPE_FRAME_STATE, nullptr, 0, 0, XR_FALSE};
  const XrFrameWaitInfo info{XR_TYPE_FRAME_WAIT_INFO, nullptr};
  return xrWaitFrame(session, &info, &state);
}

XrResult Session::begin_frame() {
  const XrFrameBeginInfo info{XR_TYPE_FRAME_BEGIN_INFO, nullptr};
  return xrBeginFrame(handle_, &info);
}

XrResult Session::locate(XrTime time, std::optional<Located>& located) {
  located.reset();
  const XrViewLocateInfo info{XR_TYPE_VIEW_LOCATE_INFO, nullptr, kViews, time, space_};
  XrViewState state{XR_TYPE_VIEW_STATE, nullptr, 0};
  std::array<XrView, kEyes> views;
  views.fill({XR_TYPE_VIEW, nullptr, kOrigin, {}});
  std::uint32_t count = kEyes;
  const XrResult result = xrLocateViews(handle_, &info, &state, count, &count, views.data());
  constexpr XrViewStateFlags valid = XR_VIEW_STATE_ORIENTATION_VALID_BIT | XR_VIEW_STATE_POSITION_VALID_BIT;
  if (XR_FAILED(result) || (state.viewStateFlags & valid) != valid) return result;
  Located found;
  if (!is_pose(views[0].pose) || !is_pose(views[1].pose)) return result;
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    found.tracked_from_eye[eye] = rigid<Eye>(views[eye].pose);
    found.fov[eye] = fov_of(views[eye].fov);
  }
  if (is_valid(found.fov[0]) && is_valid(found.fov[1])) located = found;
  return result;
}

XrResult Swapchain::acquire(vk::Image& image) const {
  std::uint32_t index = 0;
  const XrSwapchainImageAcquireInfo acquire{XR_TYPE_SWAPCHAIN_IMAGE_ACQUIRE_INFO, nullptr};
  const XrResult result = xrAcquireSwapchainImage(handle, &acquire, &index);
  if (XR_FAILED(result)) return result;
  if (index >= images.size()) return XR_ERROR_INDEX_OUT_OF_RANGE;
  image = images[index].image;
  return result;
}

XrResult Swapchain::wait() const {
  const XrSwapchainImageWaitInfo wait{XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO, nullptr, kImageTimeout_ns};
  return xrWaitSwapchainImage(handle, &wait);
}

XrResult Swapchain::release() const {
  const XrSwapchainImageReleaseInfo info{XR_TYPE_SWAPCHAIN_IMAGE_RELEASE_INFO, nullptr};
  return xrReleaseSwapchainImage(handle, &info);
}

XrResult Session::end_frame(XrTime time, const std::optional<Located>& shown, Depth depth) {
  const XrRect2Di whole{{0, 0},
                        {static_cast<std::int32_t>(size_.width), static_cast<std::int32_t>(size_.height)}};
  std::array<XrCompositionLayerProjectionView, kEyes> views{};
  std::array<XrCompositionLayerDepthInfoKHR, kEyes> depths{};
  for (std::uint32_t eye = 0; shown && eye < kEyes; ++eye) {
    // Reversed: depth 0 is infinitely far, depth 1 is at the near plane.
    depths[eye] = {XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR,
                   nullptr,
                   {depths_.handle, whole, eye},
                   0,
                   1,
                   std::numeric_limits<float>::infinity(),
                   static_cast<float>(kNearPlane_m)};
    views[eye] = {XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW,
                  depth == Depth::Submitted ? &depths[eye] : nullptr,
                  pose(shown->tracked_from_eye[eye]),
                  fov_of(shown->fov[eye]),
                  {pictures_.handle, whole, eye}};
  }
  const XrCompositionLayerProjection projection{XR_TYPE_COMPOSITION_LAYER_PROJECTION, nullptr,     0, space_,
                                                static_cast<std::uint32_t>(kEyes),    views.data()};
  const auto* const layer = reinterpret_cast<const XrCompositionLayerBaseHeader*>(&projection);
  const XrFrameEndInfo info{XR_TYPE_FRAME_END_INFO,           nullptr,         time,
                            XR_ENVIRONMENT_BLEND_MODE_OPAQUE, shown ? 1u : 0u, &layer};
  return xrEndFrame(handle_, &info);
}

}  // namespace farshade::openxr
