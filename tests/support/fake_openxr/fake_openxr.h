/// The script of a fake OpenXR runtime and its notes. The runtime is a shared object that the OpenXR loader
/// loads through XR_RUNTIME_JSON. A test opens the same shared object and gets this struct from it. It must
/// not be changed by two threads at once.
///
/// Without changes the script is a headset that is worn: sessions become focused and end when they are asked
/// to. Vulkan objects are real ones.
#pragma once

#include <vulkan/vulkan.h>
#define XR_USE_GRAPHICS_API_VULKAN
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace farshade::fake_openxr {

struct View {
  XrPosef pose{{0, 0, 0, 1}, {0, 1.6f, 0}};  ///< of the eye in the tracked space
  XrFovf fov{-0.9f, 0.7f, 0.8f, -0.85f};
};

/// What the runtime says about one frame.
struct Frame {
  bool should_render = true;
  bool is_tracked = true;  ///< the runtime knows where the head is
  std::array<View, 2> views;
};

/// What call `number` of this name (the first is 1) returns. The runtime does nothing else in it, except that
/// calls which destroy do so. A session or an instance that is said to be lost is lost from then on.
struct Answer {
  std::string call;
  std::uint32_t number = 1;
  XrResult result = XR_SUCCESS;
};

struct EyeSize {
  std::uint32_t recommended_width = 48, recommended_height = 40, largest_width = 4096, largest_height = 4096;
};

struct VisibilityMask {
  std::vector<XrVector2f> vertices;
  std::vector<std::uint32_t> indices;
};

struct SubmittedView {
  XrPosef pose;
  XrFovf fov;
  XrSwapchainSubImage picture;
  std::optional<XrCompositionLayerDepthInfoKHR> depth;
};
struct SubmittedFrame {
  XrTime time = 0;
  std::vector<SubmittedView> views;  ///< empty: a frame without a layer
};

struct SwapchainNote {
  std::int64_t format = 0;
  std::uint32_t width = 0, height = 0, layers = 0;
};

/// Handles that exist.
struct Living {
  int instances = 0, sessions = 0, spaces = 0, swapchains = 0, action_sets = 0, actions = 0;
  friend bool operator==(const Living&, const Living&) = default;
};

struct Runtime {
  // The script. A test changes it before or during a session.
  std::vector<std::string> extensions{XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME,
                                      XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME};
  XrVersion least_vulkan = XR_MAKE_VERSION(1, 1, 0);
  XrSystemId system = 1;   ///< of the headset; 0: it is not connected
  bool other_gpu = false;  ///< the headset is driven by a GPU that does not exist
  std::array<EyeSize, 2> sizes;
  std::vector<XrReferenceSpaceType> spaces{XR_REFERENCE_SPACE_TYPE_STAGE, XR_REFERENCE_SPACE_TYPE_LOCAL};
  std::vector<std::int64_t> formats{VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_D32_SFLOAT};
  std::uint32_t first_image = 0;  ///< added to the index of each acquired image
  std::vector<XrSessionState> after_begin{XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_VISIBLE,
                                          XR_SESSION_STATE_FOCUSED};
  bool ignores_exit = false;          ///< xrRequestExitSession has no effect
  XrTime first_time = 1'000'000'000;  ///< display time of the first frame
  XrDuration period = 10'000'000;
  std::function<Frame(XrTime display_time)> frame;  ///< empty: always Frame{}
  std::vector<Answer> answers;
  std::function<void(const std::string& call)> before;  ///< called first in every call
  std::deque<XrEventDataBuffer> events;                 ///< that xrPollEvent gives
  std::function<VisibilityMask(std::uint32_t view, XrVisibilityMaskTypeKHR)> mask;  ///< empty: hides nothing
  std::vector<float> refresh_rates{72, 90};
  float refresh_rate = 72;
  /// State of each action that is active, by "NAME" or "NAME /user/hand/left": x and y, 0 to 1 or -1 to 1.
  std::map<std::string, std::array<float, 2>> inputs;
  std::map<std::string, XrPosef> poses;  ///< of action spaces that are tracked, by the same names
  std::string interaction_profile = "/interaction_profiles/khr/simple_controller";

  // Notes.
  XrInstance instance = XR_NULL_HANDLE;
  XrSession session = XR_NULL_HANDLE;           ///< the one that was made last
  std::vector<std::string> enabled;             ///< extensions
  std::vector<std::string> calls;               ///< in their order, without xrPollEvent
  std::map<std::string, std::uint32_t> counts;  ///< of calls by name
  std::vector<std::string> misuses;             ///< calls that the specification does not allow
  std::vector<SubmittedFrame> frames;           ///< that were ended
  std::vector<SwapchainNote> swapchains;        ///< that were made
  std::vector<std::string> suggested;  ///< "PROFILE ACTION PATH" of xrSuggestInteractionProfileBindings
  Living living;

  template <class Event>
  void push(const Event& event) {
    static_assert(sizeof(Event) <= sizeof(XrEventDataBuffer));
    std::memcpy(&events.emplace_back(), &event, sizeof event);
  }
  /// Of the last session.
  void push(XrSessionState state) {
    push(
        XrEventDataSessionStateChanged{XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED, nullptr, session, state, 0});
  }
};

/// The functions that the shared object exports with C names.
using Restart = Runtime*();  ///< "farshade_fake_openxr_restart": forgets everything; a new script

}  // namespace farshade::fake_openxr
