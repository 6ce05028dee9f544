#include "vr_client/openxr/result.h"

#include <fmt/format.h>
#include <openxr/openxr_reflection.h>

#include <string_view>

namespace farshade::openxr {
namespace {

constexpr const char* kNoRuntime =
    "no OpenXR runtime runs here: start WiVRn, SteamVR or monado-service, or name its manifest in "
    "XR_RUNTIME_JSON";

constexpr const char* kSeeItsLog = "the log of the OpenXR runtime may say why";

/// The calls that look for a runtime.
bool opens_runtime(std::string_view call) {
  return call == "xrCreateInstance" || call == "xrEnumerateInstanceExtensionProperties";
}

/// What to do about a result, or what it means; empty if its name says enough.
const char* meaning(XrResult result, std::string_view call) {
  switch (result) {
    case XR_TIMEOUT_EXPIRED:
      return "the compositor of the OpenXR runtime gives no picture back: start the runtime again";
    case XR_ERROR_RUNTIME_UNAVAILABLE:
      return kNoRuntime;
    case XR_ERROR_RUNTIME_FAILURE:
      return opens_runtime(call) ? kNoRuntime : "the OpenXR runtime has failed: start it again";
    case XR_ERROR_FILE_ACCESS_ERROR:
    case XR_ERROR_FILE_CONTENTS_INVALID:
      return "the manifest of the OpenXR runtime cannot be read: see XR_RUNTIME_JSON";
    case XR_ERROR_API_VERSION_UNSUPPORTED:
      return "the runtime has no OpenXR 1.0";
    case XR_ERROR_EXTENSION_NOT_PRESENT:
      return "the runtime has no XR_KHR_vulkan_enable2, which this client draws through";
    case XR_ERROR_FORM_FACTOR_UNAVAILABLE:
    case XR_ERROR_SYSTEM_INVALID:
      return "no headset is connected: connect it or switch it on";
    case XR_ERROR_FORM_FACTOR_UNSUPPORTED:
      return "the runtime is for no headset";
    case XR_ERROR_GRAPHICS_DEVICE_INVALID:
      return "the headset is driven by another GPU than the one that draws: start the client again";
    case XR_ERROR_INSTANCE_LOST:
      return "the OpenXR runtime has ended: start it again";
    case XR_ERROR_SESSION_LOST:
      return "the OpenXR runtime has ended the session: start the client again";
    case XR_ERROR_LIMIT_REACHED:
      return "the runtime serves no further program: end the other one";
    case XR_ERROR_OUT_OF_MEMORY:
      return "the OpenXR runtime has no memory left: end other programs";
    default:
      return "";
  }
}

Fault fault_of(XrResult result) {
  switch (result) {
    case XR_ERROR_RUNTIME_UNAVAILABLE:
    case XR_ERROR_FORM_FACTOR_UNAVAILABLE:
    case XR_ERROR_FORM_FACTOR_UNSUPPORTED:
    case XR_ERROR_SYSTEM_INVALID:
    case XR_ERROR_SESSION_LOST:
      return Fault::Missing;
    case XR_ERROR_EXTENSION_NOT_PRESENT:
    case XR_ERROR_API_VERSION_UNSUPPORTED:
      return Fault::Unsupported;
    default:
      return Fault::Unavailable;
  }
}

}  // namespace

std::string name_of(XrResult result) {
  switch (result) {
#define FARSHADE_NAME(name, value) \
  case name:                       \
    return #name;
    XR_LIST_ENUM_XrResult(FARSHADE_NAME)
#undef FARSHADE_NAME
  }
  return fmt::format("XrResult {}", static_cast<int>(result));
}

Error error_of(XrResult result, const char* call) {
  const std::string what = meaning(result, call), said = fmt::format("{} returned {}", call, name_of(result));
  return {fault_of(result),
          what.empty() ? fmt::format("{}; {}", said, kSeeItsLog) : fmt::format("{} ({})", what, said)};
}

Expected<void> succeeded(XrResult result, const char* call) {
  if (XR_SUCCEEDED(result)) return {};
  return tl::unexpected(error_of(result, call));
}

}  // namespace farshade::openxr
