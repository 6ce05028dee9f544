/// The parts that the client benches share: a client without a network, with views along a recorded head and
/// masks that arrive some frames late, and the measured time to decode the masks.
#pragma once

#include <span>

#include "stereo/answers/assembler.h"
#include "stereo/draw/renderer.h"
#include "stereo/head/head_recording.h"

namespace farshade::bench {

inline constexpr std::uint32_t kLate_frames = 4;
inline constexpr std::uint32_t kRing_frames = kLate_frames + kMaxMasks + 1;
inline constexpr Duration kPeriod = Duration(1'000'000'000 / 72);

/// The request for a full trace of what frame `number` shows. The scene stays at its start time.
[[nodiscard]] FrameMoment shown_at(const HeadRecording& recording, const Rigid<Stage, Recorded>& placed,
                                   std::uint32_t number, std::uint32_t side_px);

/// Decodes a frame's datagrams as the client does. Returns the time that this took.
double collect_ms(Assembler& assembler, std::span<const std::vector<std::byte>> datagrams);

/// The masks of all requests that were made at least kLate_frames before `shown`.
[[nodiscard]] std::vector<TracedMask> usable_masks(const Assembler& assembler, FrameId shown);

}  // namespace farshade::bench
