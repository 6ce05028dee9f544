/// Frame packer: the answer to a request into datagrams, in memory that is used again.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "stereo/frame/shadow_frame.h"
#include "stereo/wire/messages.h"
#include "stereo/wire/plane_codec.h"
#include "stereo/wire/slice.h"

namespace farshade {

class FramePacker {
 public:
  explicit FramePacker(SameAllOver same = SameAllOver::OneValue)
      : packers_{SlicePacker(same), SlicePacker(same)} {}

  /// Another answer begins.
  void begin();

  /// Slices of left and right in turn, so that a burst of loss falls on both. `sent` has one entry a tile,
  /// 0 = not to be sent; empty: all are.
  void add(const ShadowFrame& frame, const PerEye<std::span<const std::uint8_t>>& sent = {});
  void add(FrameId frame, const GBufferPlanes& gbuffer);
  /// The parts of a coded picture, of 1 byte to kMostVideoParts * kVideoPart_bytes, that decodes after the
  /// picture of `after`, or alone where that is `frame`.
  void add(FrameId frame, FrameId after, std::span<const std::byte> video_unit);

  /// All that was added, in the order to send it, then `report`, whose `slices` and `payload_bytes` are
  /// filled in here and to whose `pack` the time is added that it took. Valid until the next begin().
  std::span<const std::vector<std::byte>> finish(FrameReport report);

  /// The datagrams of `frame` alone.
  std::span<const std::vector<std::byte>> pack(const ShadowFrame& frame, const FrameReport& report) {
    begin();
    add(frame);
    return finish(report);
  }

 private:
  void add(const ServerMessage& message);
  std::vector<std::byte>& next_datagram();

  PerEye<SlicePacker> packers_;
  PlanePacker plane_packer_;
  std::vector<std::vector<std::byte>> datagrams_;  ///< those beyond used_ keep their memory for later frames
  std::size_t used_ = 0, payload_bytes_ = 0;
  Duration packing_{};
};

}  // namespace farshade
