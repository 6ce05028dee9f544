/// OpenXR's headers with the Vulkan types that they need.
#pragma once

#include "stereo/gpu/device.h"

#define XR_USE_GRAPHICS_API_VULKAN
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>
