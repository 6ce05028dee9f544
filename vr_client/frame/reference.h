/// Reference: the client's own full trace at the pose shown. Mode `full` shows it; every other mode is
/// measured against it.
#pragma once

#include <vector>

#include "stereo/draw/shading.h"
#include "stereo/tracer/tracer.h"

namespace farshade {

class Reference {
 public:
  /// Keeps a reference to what `scene` the tracer was made of.
  explicit Reference(Tracer tracer);

  /// Every pixel of `request`'s views, at its scene time and with its lights. Valid until the next call.
  [[nodiscard]] TracedMask trace(const FrameRequest& request);

  [[nodiscard]] const TraceStats& stats() const { return stats_; }

 private:
  Tracer tracer_;
  ShadowFrame frame_;
  TraceStats stats_;
  PerEye<KnownTiles> all_known_;
  std::uint64_t traces_ = 0;
};

}  // namespace farshade
