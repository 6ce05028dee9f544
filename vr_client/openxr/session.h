/// Session: an OpenXR session with its space and its swapchains, and the calls of a frame. It knows nothing
/// of the life cycle: calls at the wrong time return the runtime's errors.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "stereo/frame/view.h"
#include "vr_client/openxr/instance.h"
#include "vr_client/runtime/hands.h"

namespace farshade::openxr {

/// Where the eyes are and what they see, at one time.
struct Located {
  PerEye<Rigid<Tracked, Eye>> tracked_from_eye;
  PerEye<EyeFov> fov;
};

/// Images of the runtime with one layer an eye.
struct Swapchain {
  XrSwapchain handle = XR_NULL_HANDLE;
  vk::Format format = vk::Format::eUndefined;
  std::vector<XrSwapchainImageVulkanKHR> images;

  // Calls for each picture, in this order.
  /// The next image. Its layout is that of an attachment, and must be that again when it is released.
  [[nodiscard]] XrResult acquire(vk::Image& image) const;
  /// Waits until the compositor has read the acquired image. XR_TIMEOUT_EXPIRED after 2 s.
  [[nodiscard]] XrResult wait() const;
  [[nodiscard]] XrResult release() const;
};

/// Whether a display can have this refresh rate: above 0 and at most 1,000 Hz.
[[nodiscard]] bool is_rate(float refresh_hz);

/// Whether a frame submits the depth of its picture, too.
enum class Depth : std::uint8_t { None, Submitted };

class Session {
 public:
  /// `size` is that of each view, pixels. Keeps both references.
  [[nodiscard]] static Expected<std::unique_ptr<Session>> open(const Instance& instance,
                                                               const gpu::Device& device, Extent size);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session();
  /// Leaves the session to the end of the program: a call that blocks still uses it.
  void abandon() { handle_ = XR_NULL_HANDLE; }

  [[nodiscard]] XrSession handle() const { return handle_; }
  [[nodiscard]] XrSpace space() const { return space_; }
  [[nodiscard]] XrReferenceSpaceType space_type() const { return space_type_; }
  [[nodiscard]] const char* space_name() const {
    return space_type_ == XR_REFERENCE_SPACE_TYPE_STAGE ? "stage" : "local";
  }

  /// Of the display, Hz. No value if the runtime does not state it.
  [[nodiscard]] std::optional<double> refresh_hz() const;

  // Calls of the life cycle and of a frame, in this order. Each returns the runtime's result.
  [[nodiscard]] XrResult begin();
  [[nodiscard]] XrResult end();
  [[nodiscard]] XrResult request_exit();
  /// xrWaitFrame may come from another thread than the others, and may block for as long as the runtime
  /// likes.
  [[nodiscard]] static XrResult wait_frame(XrSession session, XrFrameState& state);
  [[nodiscard]] XrResult begin_frame();
  /// Empty `located`: the runtime does not know where the head looks.
  [[nodiscard]] XrResult locate(XrTime time, std::optional<Located>& located);
  [[nodiscard]] const Swapchain& pictures() const { return pictures_; }
  /// Null if the runtime takes no depth. Depths are those of stereo/math/fov.h.
  [[nodiscard]] const Swapchain* depths() const {
    return depths_.handle == XR_NULL_HANDLE ? nullptr : &depths_;
  }
  /// Shows the released images as the two views, or nothing.
  [[nodiscard]] XrResult end_frame(XrTime time, const std::optional<Located>& shown, Depth depth);

 private:
  Session(const Instance& instance, Extent size) : instance_(instance), size_(size) {}
  [[nodiscard]] Expected<void> create(const gpu::Device& device);
  [[nodiscard]] Expected<void> create_space();
  [[nodiscard]] Expected<void> create_swapchains();
  [[nodiscard]] Expected<void> fill(Swapchain& swapchain, XrSwapchainUsageFlags usage) const;

  const Instance& instance_;
  Extent size_;
  XrSession handle_ = XR_NULL_HANDLE;
  XrSpace space_ = XR_NULL_HANDLE;
  XrReferenceSpaceType space_type_ = XR_REFERENCE_SPACE_TYPE_STAGE;
  Swapchain pictures_, depths_;
};

}  // namespace farshade::openxr
