/// Session: an OpenXR session with its space and its swapchain, and the calls of a frame. It knows nothing of
/// the life cycle: calls at the wrong time return the runtime's errors.
#pragma once

#include <memory>
#include <vector>

#include "stereo/frame/view.h"
#include "vr_client/openxr/instance.h"

namespace farshade::openxr {

/// The space in which the runtime gives poses: STAGE, or LOCAL if there is none.
struct Tracked;

/// Where the eyes are and what they see, at one time.
struct Located {
  PerEye<Rigid<Tracked, Eye>> tracked_from_eye;
  PerEye<EyeFov> fov;
};

class Session {
 public:
  /// `size` is that of each view, pixels. Keeps both references.
  [[nodiscard]] static Expected<std::unique_ptr<Session>> open(const Instance& instance,
                                                               const gpu::Device& device, Extent size);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session();

  [[nodiscard]] XrSession handle() const { return handle_; }
  [[nodiscard]] const char* space_name() const { return space_name_; }
  [[nodiscard]] vk::Format format() const { return format_; }

  // Calls of the life cycle and of a frame, in this order. Each returns the runtime's result.
  [[nodiscard]] XrResult begin();
  [[nodiscard]] XrResult end();
  [[nodiscard]] XrResult request_exit();
  [[nodiscard]] XrResult wait_frame(XrFrameState& state);
  [[nodiscard]] XrResult begin_frame();
  /// Empty `located`: the runtime does not know where the head looks.
  [[nodiscard]] XrResult locate(XrTime time, std::optional<Located>& located);
  /// An image with one layer an eye to draw to; its layout is that of a colour attachment, before and after.
  [[nodiscard]] XrResult acquire(vk::Image& image);
  [[nodiscard]] XrResult release();
  /// Shows the released image as the two views, or nothing.
  [[nodiscard]] XrResult end_frame(XrTime time, const std::optional<Located>& shown);

 private:
  Session(const Instance& instance, Extent size) : instance_(instance), size_(size) {}
  [[nodiscard]] Expected<void> create(const gpu::Device& device);
  [[nodiscard]] Expected<void> create_space();
  [[nodiscard]] Expected<void> choose_format();
  [[nodiscard]] Expected<void> create_swapchain();

  const Instance& instance_;
  Extent size_;
  XrSession handle_ = XR_NULL_HANDLE;
  XrSpace space_ = XR_NULL_HANDLE;
  const char* space_name_ = "";
  XrSwapchain swapchain_ = XR_NULL_HANDLE;
  vk::Format format_ = vk::Format::eUndefined;
  std::vector<XrSwapchainImageVulkanKHR> images_;
};

}  // namespace farshade::openxr
