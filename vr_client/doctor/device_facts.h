/// `vr_client device`: the facts of the Vulkan device that the client would draw on, as JSON for
/// scripts/gpu-bundle's check and for reports of faults.
#pragma once

#include <string>

#include "stereo/base/expected.h"

namespace CLI {
class App;
}

namespace farshade {

struct DeviceFactsOptions {
  std::string gpu;  ///< only a device whose name contains this; empty: any
};

/// Adds the subcommand `device` and its options to the program. `options` must outlive the parsing.
void add_device_facts(CLI::App& program, DeviceFactsOptions& options);

/// Name, driver, queues, memory and limits of the device that `open_device` chooses, as a JSON object that
/// ends with a newline.
[[nodiscard]] Expected<std::string> device_facts(const DeviceFactsOptions& options);

}  // namespace farshade
