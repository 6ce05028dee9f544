/// Tracer: which lights does each pixel's surface see? Primary rays through the pixel centres of both views, then
/// for each pixel and each light that can matter there (covered, facing, in range and cone) one any-hit ray.
/// The server answers requests with it; the client's reference mode `full` calls it directly.
/// Only tracer.cpp names Embree (3 or 4).
#pragma once

#include <memory>

#include "stereo/frame/shadow_frame.h"
#include "stereo/scene/scene_state.h"

namespace farshade {

struct TraceStats {
  Duration primary{}, shadow{};
  std::uint64_t primary_rays = 0, shadow_rays = 0;
  /// What a trace that leaves nothing out would cost: covered pixels x lights, both eyes.
  std::uint64_t full_shadow_rays = 0;
};

class Tracer {
 public:
  /// Builds the acceleration structure. Keeps a reference to `scene`.
  /// Refuses (Fault::Unavailable) when the device or its memory is not to be had.
  [[nodiscard]] static Expected<Tracer> create(const Scene& scene);

  Tracer(Tracer&&) noexcept;
  Tracer& operator=(Tracer&&) noexcept;
  ~Tracer();

  /// Traces `request` against the scene at its scene_time into `frame`, whose buffers are reused.
  /// One call at a time; uses all cores.
  TraceStats trace(const TraceRequest& request, ShadowFrame& frame);

 private:
  struct Impl;
  explicit Tracer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace farshade
