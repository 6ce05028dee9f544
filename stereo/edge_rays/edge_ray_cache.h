/// Edge ray cache: keeps light buffers in a file, so that they are made once. A file that is broken or from
/// another version is ignored and replaced.
#pragma once

#include <filesystem>

#include "stereo/edge_rays/edge_ray_data.h"

namespace farshade {

/// The file of these buffers in `folder`. Its name has a digest of all that they depend on.
[[nodiscard]] std::filesystem::path edge_ray_file(const std::filesystem::path& folder,
                                                  const EdgeRayInput& input);

/// Data, and how they were obtained.
struct CachedEdgeRayData {
  EdgeRayData data;
  bool from_file = false;
  std::string trouble{};  ///< why the file was not read or written; empty if all went well
};

/// Reads the buffers from `folder`; if there are none, makes them as make_edge_ray_data does and writes them
/// there, unless `stop` is requested. Every index of a file is checked. Without a usable folder the buffers
/// are made every time.
[[nodiscard]] CachedEdgeRayData cached_edge_ray_data(const EdgeRayInput& input,
                                                     const std::filesystem::path& folder,
                                                     const std::stop_token& stop = {});

}  // namespace farshade
