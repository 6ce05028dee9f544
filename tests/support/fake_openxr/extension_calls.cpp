// XR_KHR_visibility_mask and XR_FB_display_refresh_rate. A script that names them in `extensions` offers
// them.
#include "tests/support/fake_openxr/runtime.h"

namespace farshade::fake_openxr {
namespace {

XrResult get_mask(XrSession, XrViewConfigurationType type, std::uint32_t view, XrVisibilityMaskTypeKHR kind,
                  XrVisibilityMaskKHR* out) {
  if (type != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO) return XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED;
  if (view > 1) return misuse(XR_ERROR_VALIDATION_FAILURE, "xrGetVisibilityMaskKHR of a third view");
  const auto& script = state().script.mask;
  const VisibilityMask mask = script ? script(view, kind) : VisibilityMask{};
  const XrResult vertices =
      enumerate<XrVector2f>(mask.vertices, out->vertexCapacityInput, &out->vertexCountOutput, out->vertices);
  const XrResult indices =
      enumerate<std::uint32_t>(mask.indices, out->indexCapacityInput, &out->indexCountOutput, out->indices);
  return XR_FAILED(vertices) ? vertices : indices;
}

XrResult enumerate_rates(XrSession, std::uint32_t capacity, std::uint32_t* count, float* rates) {
  return enumerate<float>(state().script.refresh_rates, capacity, count, rates);
}

XrResult get_rate(XrSession, float* rate) {
  *rate = state().script.refresh_rate;
  return XR_SUCCESS;
}

XrResult request_rate(XrSession, float rate) {
  Runtime& script = state().script;
  if (rate == 0) return XR_SUCCESS;  // the client has no wish
  if (std::ranges::find(script.refresh_rates, rate) == script.refresh_rates.end())
    return XR_ERROR_DISPLAY_REFRESH_RATE_UNSUPPORTED_FB;
  script.push(XrEventDataDisplayRefreshRateChangedFB{XR_TYPE_EVENT_DATA_DISPLAY_REFRESH_RATE_CHANGED_FB,
                                                     nullptr, script.refresh_rate, rate});
  script.refresh_rate = rate;
  script.period = static_cast<XrDuration>(1e9f / rate);
  return XR_SUCCESS;
}

}  // namespace

std::vector<Function> extension_calls() {
  constexpr const char* kMask = XR_KHR_VISIBILITY_MASK_EXTENSION_NAME;
  constexpr const char* kRate = XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME;
  return {entry<"xrGetVisibilityMaskKHR", &get_mask>(kMask),
          entry<"xrEnumerateDisplayRefreshRatesFB", &enumerate_rates>(kRate),
          entry<"xrGetDisplayRefreshRateFB", &get_rate>(kRate),
          entry<"xrRequestDisplayRefreshRateFB", &request_rate>(kRate)};
}

}  // namespace farshade::fake_openxr
