/// The device that unit tests use, with the validation layers.
#pragma once

#include "stereo/gpu/device.h"
#include "tests/support/test_place.h"

namespace farshade::gpu {

[[nodiscard]] inline Expected<Device> open_validated_device() {
  DeviceOptions options;
  options.validation = Validation::On;
  options.name_contains = test_gpu();
  return open_device(options);
}

}  // namespace farshade::gpu
