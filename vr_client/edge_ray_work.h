/// EdgeRayWork: makes EdgeRayData on a thread of low priority, while frames are shown without them.
#pragma once

#include <string>
#include <thread>

#include "stereo/edge_rays/edge_ray_data.h"

namespace farshade {

class EdgeRayWork {
 public:
  /// Keeps the reference. `most_texels` is that of the device.
  EdgeRayWork(const Scene& scene, const DrawPlan& plan, std::uint64_t most_texels);

  [[nodiscard]] const FutureEdgeRayData& data() const { return data_; }
  [[nodiscard]] bool is_done() const;

 private:
  FutureEdgeRayData data_;
  std::jthread thread_;  ///< its end stops the work
};

/// "10.2 MB of light buffers and triangles, for 3 of 4 lights"
[[nodiscard]] std::string in_words(const EdgeRayData& data);

}  // namespace farshade
