#include "vr_client/frame/reference.h"

namespace farshade {

Reference::Reference(Tracer tracer) : tracer_(std::move(tracer)) {}

TracedMask Reference::trace(const FrameMoment& moment) {
  static_cast<void>(tracer_.trace({moment}, mask_.frame));
  mask_.display_time = moment.display_time;
  mask_.scene_time = moment.scene_time;
  mask_.receive_all();
  // The content number of a server's mask is a count of tiles. This one never equals it.
  mask_.content = std::uint64_t{1} << 63 | ++traces_;
  return mask_.traced();
}

}  // namespace farshade
