/// The results of OpenXR calls in words, and as errors.
#pragma once

#include <string>

#include "stereo/base/expected.h"
#include "vr_client/openxr/openxr.h"

namespace farshade::openxr {

/// "XR_ERROR_SESSION_LOST", for example.
[[nodiscard]] std::string name_of(XrResult result);

/// An error that names the call, its result and the cure. Missing if there is no runtime or no headset, or
/// the headset has gone; Unsupported if the runtime is too old or lacks an extension; otherwise Unavailable.
/// `result` may be XR_TIMEOUT_EXPIRED.
[[nodiscard]] Error error_of(XrResult result, const char* call);

/// Nothing for every success code, XR_SESSION_LOSS_PENDING included; otherwise error_of.
[[nodiscard]] Expected<void> succeeded(XrResult result, const char* call);

}  // namespace farshade::openxr
