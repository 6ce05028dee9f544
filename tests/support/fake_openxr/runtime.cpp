#include "tests/support/fake_openxr/runtime.h"

namespace farshade::fake_openxr {

State& state() {
  static State state;
  return state;
}

std::optional<XrResult> enter(const char* call) {
  Runtime& script = state().script;
  if (script.before) script.before(call);
  const std::uint32_t number = ++script.counts[call];
  if (std::string_view(call) != "xrPollEvent") script.calls.emplace_back(call);
  for (const Answer& answer : script.answers)
    if (answer.call == call && answer.number == number) return answer.result;
  return std::nullopt;
}

XrResult misuse(XrResult result, std::string what) {
  state().script.misuses.push_back(std::move(what));
  return result;
}

XrResult refusal(XrInstance instance) {
  if (state().instance_is_lost) return XR_ERROR_INSTANCE_LOST;
  if (instance == state().script.instance) return XR_SUCCESS;
  return misuse(XR_ERROR_HANDLE_INVALID, "an instance that does not exist");
}

XrResult refusal(XrSession session) {
  if (state().instance_is_lost) return XR_ERROR_INSTANCE_LOST;
  const auto found = state().sessions.find(session);
  if (found == state().sessions.end())
    return misuse(XR_ERROR_HANDLE_INVALID, "a session that does not exist");
  return found->second.is_lost ? XR_ERROR_SESSION_LOST : XR_SUCCESS;
}

XrResult refusal(XrSwapchain swapchain) {
  const auto found = state().swapchains.find(swapchain);
  if (found == state().swapchains.end())
    return misuse(XR_ERROR_HANDLE_INVALID, "a swapchain that does not exist");
  return refusal(found->second.session);
}

void lose(XrSession session) {
  if (const auto found = state().sessions.find(session); found != state().sessions.end())
    found->second.is_lost = true;
}

void lose(XrSwapchain swapchain) {
  if (const auto found = state().swapchains.find(swapchain); found != state().swapchains.end())
    lose(found->second.session);
}

bool is_enabled(const char* extension) {
  return std::ranges::find(state().script.enabled, extension) != state().script.enabled.end();
}

namespace {

const std::vector<Function>& functions() {
  static const std::vector<Function> all = [] {
    std::vector<Function> functions;
    for (const auto& calls : {instance_calls(), vulkan_calls(), session_calls(), frame_calls(),
                              extension_calls(), action_calls()})
      functions.insert(functions.end(), calls.begin(), calls.end());
    return functions;
  }();
  return all;
}

XRAPI_ATTR XrResult XRAPI_CALL get_instance_proc_addr(XrInstance, const char* name,
                                                      PFN_xrVoidFunction* function) {
  *function = nullptr;
  if (std::string_view(name) == "xrGetInstanceProcAddr") {
    *function = reinterpret_cast<PFN_xrVoidFunction>(&get_instance_proc_addr);
    return XR_SUCCESS;
  }
  const auto found = std::ranges::find_if(
      functions(), [&](const Function& one) { return std::strcmp(one.name, name) == 0; });
  if (found == functions().end() || (found->extension && !is_enabled(found->extension)))
    return XR_ERROR_FUNCTION_UNSUPPORTED;
  *function = found->function;
  return XR_SUCCESS;
}

}  // namespace

/// What the loader and a runtime tell each other. Newer headers than those of OpenXR 1.0.20 have these
/// structs, too. Source: OpenXR loader specification, section "Loader/Runtime Interface Negotiation".
struct LoaderInfo {
  std::int32_t type;
  std::uint32_t version;
  std::size_t bytes;
  std::uint32_t least_interface, newest_interface;
  XrVersion least_api, newest_api;
};
struct RuntimeRequest {
  std::int32_t type;
  std::uint32_t version;
  std::size_t bytes;
  std::uint32_t interface_version;
  XrVersion api;
  PFN_xrGetInstanceProcAddr get_instance_proc_addr;
};

}  // namespace farshade::fake_openxr

extern "C" {

__attribute__((visibility("default"))) farshade::fake_openxr::Runtime* farshade_fake_openxr_restart() {
  farshade::fake_openxr::state() = {};
  return &farshade::fake_openxr::state().script;
}

__attribute__((visibility("default"))) XrResult xrNegotiateLoaderRuntimeInterface(
    const farshade::fake_openxr::LoaderInfo* loader, farshade::fake_openxr::RuntimeRequest* request) {
  constexpr std::uint32_t kInterface = 1;
  if (const auto answer = farshade::fake_openxr::enter("xrNegotiateLoaderRuntimeInterface")) return *answer;
  if (loader->least_interface > kInterface || loader->newest_interface < kInterface)
    return XR_ERROR_INITIALIZATION_FAILED;
  request->interface_version = kInterface;
  request->api = XR_MAKE_VERSION(1, 0, 20);
  request->get_instance_proc_addr = &farshade::fake_openxr::get_instance_proc_addr;
  return XR_SUCCESS;
}

}  // extern "C"
