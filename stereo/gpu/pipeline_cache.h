/// Pipeline cache: keeps the driver's compiled pipelines in a file between runs of a program.
#pragma once

#include <filesystem>

#include "stereo/gpu/device.h"

namespace farshade::gpu {

/// The file of this device and driver in `folder`.
[[nodiscard]] std::filesystem::path pipeline_file(const Device& device, const std::filesystem::path& folder);

/// Lets `device` start with the pipelines of the file in `folder`. Returns whether there is a whole file. The
/// driver ignores one of another driver.
bool load_pipelines(Device& device, const std::filesystem::path& folder);

/// Writes the pipelines of `device` to its file in `folder`, which is made if necessary.
[[nodiscard]] Expected<void> save_pipelines(const Device& device, const std::filesystem::path& folder);

}  // namespace farshade::gpu
