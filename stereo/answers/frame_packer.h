/// FramePacker: encodes the answer to a request as messages.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "stereo/answers/video_parts.h"
#include "stereo/codec/plane_codec.h"
#include "stereo/codec/slice.h"
#include "stereo/frame/shadow_frame.h"
#include "stereo/messages/messages.h"

namespace farshade {

class FramePacker {
 public:
  /// Begins another answer. Its messages have at most `most_bytes`, which are kBaseMessage_bytes to
  /// kMaxMessage_bytes; those of a coded picture have at most kBaseMessage_bytes. `version` is that of the
  /// session.
  void begin(std::size_t most_bytes = kBaseMessage_bytes, ProtocolVersion version = kProtocolVersion);

  /// Adds slices from the middle row of the views outwards, so that what matters most comes first, and those
  /// of both eyes in turn, so that a burst of loss affects both. They contain the blocks `requested`. `sent`
  /// has one entry for each tile, 0: the tile is not sent. If it is empty, all tiles are sent.
  void add(const ShadowFrame& frame, const RequestedBlocks& requested = {},
           const PerEye<std::span<const std::uint8_t>>& sent = {});
  void add(FrameId frame, const GBufferPlanes& gbuffer);
  /// Adds a coded picture or a block of masks of 1 to kMostVideoParts parts. It depends on the picture of
  /// `after`; if that is `frame`, it depends on none.
  void add(FrameId frame, FrameId after, const VideoUnitParts& parts);

  /// Hands over the messages in the order in which to send them, `report` last, and keeps none. Sets the
  /// report's `slices` and `payload_bytes`, and adds the time that packing took to its `pack`.
  [[nodiscard]] std::vector<std::vector<std::byte>> finish(FrameReport report);

 private:
  void add(const ServerMessage& message);
  std::vector<std::byte>& next_datagram();
  void sort_from(std::size_t first);

  PerEye<SlicePacker> packers_;
  PlanePacker plane_packer_;
  std::vector<std::vector<std::byte>> datagrams_;
  std::vector<std::uint32_t> from_middle_;  ///< of slices being added: tiles to the view's middle row
  std::size_t most_bytes_ = kBaseMessage_bytes, payload_bytes_ = 0;
  ProtocolVersion version_ = kProtocolVersion;
  Duration packing_{};
};

}  // namespace farshade
