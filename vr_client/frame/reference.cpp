#include "vr_client/frame/reference.h"

#include "stereo/frame/tiles.h"

namespace farshade {

Reference::Reference(Tracer tracer) : tracer_(std::move(tracer)) {}

TracedMask Reference::trace(const FrameMoment& moment) {
  static_cast<void>(tracer_.trace({moment}, frame_));
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    all_known_[eye].assign(TileGrid{moment.views[eye].size}.count(),
                           all_planes_received(frame_.masks[eye].layout()));
  // The content number of a server's mask is a count of tiles. This one never equals it.
  const std::uint64_t content = std::uint64_t{1} << 63 | ++traces_;
  return {moment.frame, moment.display_time, moment.scene_time, frame_.views,
          frame_.masks, all_known_,          content,           frame_.light_set_revision};
}

}  // namespace farshade
