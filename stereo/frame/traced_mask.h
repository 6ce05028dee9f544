/// TracedMask: a mask of both eyes with all that its bits depend on, and which of them are known. It refers
/// to data that others own: the record of a request, or an OwnedMask.
#pragma once

#include <cstdint>
#include <optional>

#include "stereo/frame/received_tiles.h"
#include "stereo/frame/shadow_frame.h"
#include "stereo/frame/tiles.h"

namespace farshade {

/// A mask as it is reprojected. The references must be valid as long as it is used.
struct TracedMask {
  FrameId frame;
  Time display_time;        ///< of the request
  Time scene_time;          ///< of the traced scene
  const StereoView& views;  ///< traced views, both of one size
  const PerEye<EyeMask>& masks;
  const PerEye<ReceivedTiles>& received_tiles;
  std::uint64_t content = 0;  ///< changes whenever the bits or received tiles do
  /// The light set that was traced. Bits of lights that the viewer has changed since are stale.
  LightSetRevision light_set_revision = kFirstLightSet;
  /// The blocks that were asked for; the others were reprojected and are known. Null: all.
  const RequestedBlocks* requested = nullptr;
  Time requested_at{};  ///< the display time of the frame that made the request
};

/// The blocks of a tile that are known: those that were reprojected, and once all planes of the tile have
/// come, all.
[[nodiscard]] inline BlockBits known_blocks(const TracedMask& mask, std::size_t eye, std::size_t tile) {
  if (mask.received_tiles[eye][tile] == all_planes_received(mask.masks[eye].layout())) return kAllBlocks;
  return mask.requested == nullptr ? kNoBlocks : static_cast<BlockBits>(~mask.requested->at(eye, tile));
}

/// A mask that owns what a TracedMask refers to.
struct OwnedMask {
  ShadowFrame frame;
  Time display_time{}, scene_time{};
  PerEye<ReceivedTiles> received_tiles{};
  std::uint64_t content = 0;
  std::optional<RequestedBlocks> requested{};  ///< nothing: all

  /// All tiles of the frame's masks are known.
  void receive_all() {
    for (std::size_t eye = 0; eye < kEyes; ++eye)
      received_tiles[eye].assign(TileGrid{frame.masks[eye].size()}.count(),
                                 all_planes_received(frame.masks[eye].layout()));
  }
  /// Valid as long as this object, and until it is changed.
  [[nodiscard]] TracedMask traced() const {
    return {frame.frame,
            display_time,
            scene_time,
            frame.views,
            frame.masks,
            received_tiles,
            content,
            frame.light_set_revision,
            requested ? &*requested : nullptr};
  }
};

}  // namespace farshade
