/// Job: a request whose turn it is, with all that its answer depends on. A session makes it, a worker answers
/// it, and the session learns how it ended.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "stereo/base/clock.h"
#include "stereo/frame/shadow_frame.h"
#include "stereo/frame/view_scale.h"
#include "stereo/sealing/handshake.h"

namespace farshade {

/// A request that is to be answered now.
struct Job {
  SessionId session{};
  KeyId key{};                                 ///< of the session
  ProtocolVersion version = kProtocolVersion;  ///< of the session
  FrameRequest request;
  Time arrived;
  std::uint32_t superseded = 0;        ///< requests of this client so far that a newer one replaced
  std::uint32_t bytes_per_second = 0;  ///< estimated capacity of the path to the client
  ViewScale view_scale{};              ///< the size of views that the client should request next
  std::size_t most_message_bytes = kBaseMessage_bytes;  ///< that the path to the client carries
  /// The messages that the request announced and that have arrived: AskSlices with the blocks that it asks
  /// for, or PlaneSlices with its positions. Each has been decoded once, so it is well-formed.
  std::vector<std::vector<std::byte>> parts{};
  bool is_too_costly = false;           ///< gets an answer without content (rt_server/scheduling/job_costs.h)
  std::function<bool()> is_given_up{};  ///< whether to stop work on it; empty: never. Any thread may call it
};

/// How a job ended.
enum class JobEnd : std::uint8_t {
  Answered,
  GivenUp,  ///< also without having begun, because it was too costly
};

/// A message that waits takes so much more memory than it has bytes.
inline constexpr std::size_t kMessage_bytes = 64;

}  // namespace farshade
