#include "tests/bench/late_masks.h"

#include "vr_client/runtime/headset.h"

namespace farshade::bench {

FrameMoment shown_at(const HeadRecording& recording, const Rigid<Stage, Recorded>& placed,
                     std::uint32_t number, std::uint32_t side_px) {
  const Time time = recording.start() + kPeriod * number;
  const Headset headset{recording.eye_distance_m, recording.fov, {side_px, side_px}};
  return {{number}, time, Time{}, views_of(placed * head_at(recording, time), headset), {}};
}

double collect_ms(Assembler& assembler, std::span<const std::vector<std::byte>> datagrams) {
  const Stopwatch watch;
  for (const std::vector<std::byte>& datagram : datagrams) {
    const Decoded<ServerMessage> message = decode_server(datagram);
    if (const auto* slice = message ? std::get_if<Slice>(&*message) : nullptr) assembler.accept(*slice);
  }
  return ms_of(watch.elapsed());
}

std::vector<TracedMask> usable_masks(const Assembler& assembler, FrameId shown) {
  std::vector<TracedMask> masks;
  for (std::uint32_t age = kLate_frames; age < kLate_frames + kMaxMasks; ++age)
    if (const RequestRecord* frame = assembler.find({shown.value - age}); frame && frame->complete())
      masks.push_back({frame->request.frame, frame->request.display_time, frame->request.scene_time,
                       frame->request.views, frame->masks, frame->received_tiles, 1});
  return masks;
}

}  // namespace farshade::bench
