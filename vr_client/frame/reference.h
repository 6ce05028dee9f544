/// Reference: the client's own full trace at the shown pose. Mode `full` shows it. All other modes are
/// measured against it.
#pragma once

#include "stereo/reproject/reprojection.h"
#include "stereo/tracer/tracer.h"

namespace farshade {

class Reference {
 public:
  /// The scene that the tracer was made from must outlive it.
  explicit Reference(Tracer tracer);

  /// Traces every pixel of the views of `moment`, at its scene time and with its lights. The mask is valid
  /// until the next call.
  [[nodiscard]] TracedMask trace(const FrameMoment& moment);

  /// The surfaces that its primary rays meet (tracer.h).
  [[nodiscard]] PerEye<Image<float>> distances(const FrameMoment& moment) {
    return tracer_.distances(moment);
  }

 private:
  Tracer tracer_;
  OwnedMask mask_;
  std::uint64_t traces_ = 0;
};

}  // namespace farshade
