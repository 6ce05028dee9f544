/// The results of OpenXR calls in words, and as errors.
#pragma once

#include <string>

#include "stereo/base/expected.h"
#include "vr_client/openxr/openxr.h"

namespace farshade::openxr {

/// "XR_ERROR_SESSION_LOST", for example.
[[nodiscard]] std::string name_of(XrResult result);

/// An error that names the call, its result and, if known, the cure. Missing if there is no runtime or no
/// headset, otherwise Unavailable.
[[nodiscard]] Error error_of(XrResult result, const char* call);

/// Nothing for every success code, XR_SESSION_LOSS_PENDING included; otherwise error_of.
[[nodiscard]] Expected<void> succeeded(XrResult result, const char* call);

}  // namespace farshade::openxr
