/// The state behind the script, and how every call begins.
#pragma once

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "tests/support/fake_openxr/fake_openxr.h"

namespace farshade::fake_openxr {

struct SessionParts {
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  XrSessionState state = XR_SESSION_STATE_UNKNOWN;  ///< that the client knows
  bool is_running = false, is_lost = false, exits = false;
  enum class Frame : std::uint8_t { None, Waited, Begun } frame = Frame::None;
  XrTime time = 0;  ///< of the last frame
};

struct SwapchainParts {
  XrSession session = XR_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  std::vector<VkImage> images;
  std::vector<VkDeviceMemory> memories;
  std::uint32_t next = 0;
  enum class Image : std::uint8_t { None, Acquired, Waited } image = Image::None;
  bool has_content = false;  ///< an image was released
};

struct SpaceParts {
  XrSession session = XR_NULL_HANDLE;
  std::string action;  ///< as in Runtime::poses; empty: a reference space
};

struct ActionParts {
  XrActionSet set = XR_NULL_HANDLE;
  std::string name;
};

struct State {
  Runtime script;
  std::uint64_t last_handle = 0;
  bool instance_is_lost = false;
  std::set<XrSystemId> asked;  ///< systems whose graphics requirements were asked for
  std::map<XrSession, SessionParts> sessions;
  std::map<XrSwapchain, SwapchainParts> swapchains;
  std::map<XrSpace, SpaceParts> spaces;
  std::set<XrActionSet> action_sets;
  std::map<XrAction, ActionParts> actions;
  std::vector<std::string> paths;  ///< XrPath is the index + 1

  template <class Handle>
  Handle new_handle() {
    return reinterpret_cast<Handle>(++last_handle);
  }
};

[[nodiscard]] State& state();

/// Notes the call. Its result, if the script has one for it.
[[nodiscard]] std::optional<XrResult> enter(const char* call);

/// Notes a call that the specification does not allow.
[[nodiscard]] XrResult misuse(XrResult result, std::string what);

/// Why a call with this first argument cannot be carried out; XR_SUCCESS: it can.
[[nodiscard]] XrResult refusal(XrInstance instance);
[[nodiscard]] XrResult refusal(XrSession session);
[[nodiscard]] XrResult refusal(XrSwapchain swapchain);
[[nodiscard]] XrResult refusal(auto) {
  return state().instance_is_lost ? XR_ERROR_INSTANCE_LOST : XR_SUCCESS;
}

void lose(XrSession session);
void lose(XrSwapchain swapchain);
void lose(auto) {}

[[nodiscard]] bool is_enabled(const char* extension);

/// Answers a call that gives a number of items, or the items if there is room for them.
template <class T>
[[nodiscard]] XrResult enumerate(std::span<const T> items, std::uint32_t capacity, std::uint32_t* count,
                                 T* out) {
  *count = static_cast<std::uint32_t>(items.size());
  if (capacity == 0) return XR_SUCCESS;
  if (capacity < items.size()) return XR_ERROR_SIZE_INSUFFICIENT;
  std::ranges::copy(items, out);
  return XR_SUCCESS;
}

/// A name as a template argument.
template <std::size_t N>
struct Name {
  char text[N]{};
  constexpr Name(const char (&from)[N]) { std::copy_n(from, N, text); }
};

/// `function` as the loader calls it.
template <Name name, auto function>
struct Entry;
template <Name name, class First, class... Rest, XrResult (*function)(First, Rest...)>
struct Entry<name, function> {
  static XRAPI_ATTR XrResult XRAPI_CALL call(First first, Rest... rest) {
    constexpr bool destroys = std::string_view(name.text).starts_with("xrDestroy");
    const std::optional<XrResult> answer = enter(name.text);
    if constexpr (destroys) {
      const XrResult done = function(first, rest...);
      return answer.value_or(done);
    } else {
      if (answer == XR_ERROR_SESSION_LOST) lose(first);
      if (answer == XR_ERROR_INSTANCE_LOST) state().instance_is_lost = true;
      if (answer) return *answer;
      const XrResult refused = refusal(first);
      return XR_FAILED(refused) ? refused : function(first, rest...);
    }
  }
};

struct Function {
  const char* name;
  PFN_xrVoidFunction function;
  const char* extension = nullptr;  ///< that it belongs to
};
template <Name name, auto function>
[[nodiscard]] Function entry(const char* extension = nullptr) {
  return {name.text, reinterpret_cast<PFN_xrVoidFunction>(&Entry<name, function>::call), extension};
}

// The calls of each source.
[[nodiscard]] std::vector<Function> instance_calls();
[[nodiscard]] std::vector<Function> vulkan_calls();
[[nodiscard]] std::vector<Function> session_calls();
[[nodiscard]] std::vector<Function> frame_calls();
[[nodiscard]] std::vector<Function> extension_calls();
[[nodiscard]] std::vector<Function> action_calls();

}  // namespace farshade::fake_openxr
