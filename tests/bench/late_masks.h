/// A client's session without a network: views along a recorded head, masks that come some frames late, and
/// the time it takes to take them in. What the benches of clients share.
#pragma once

#include <span>

#include "stereo/draw/renderer.h"
#include "stereo/head/head_recording.h"
#include "stereo/net/assembler.h"

namespace farshade::bench {

inline constexpr std::uint32_t kLate_frames = 4;
inline constexpr std::uint32_t kRing_frames = kLate_frames + ShadingPass::kMaxMasks + 1;
inline constexpr Duration kPeriod = Duration(1'000'000'000 / 72);

/// What frame `number` shows, as a full trace would be asked for it. The scene stands at its start.
[[nodiscard]] FrameRequest shown_at(const HeadRecording& trace, const Rigid<Stage, Recorded>& placed,
                                    std::uint32_t number, std::uint32_t side_px);

/// Takes in a frame's datagrams as the client does; the time that took.
double collect_ms(Assembler& assembler, std::span<const std::vector<std::byte>> datagrams);

/// Those of requests kLate_frames before `shown` and earlier.
[[nodiscard]] std::vector<TracedMask> masks_in_hand(const Assembler& assembler, FrameId shown);

}  // namespace farshade::bench
