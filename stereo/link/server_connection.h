/// ServerConnection: what a run of the client needs of the source of its answers. There are two: the network
/// (network_link.h) and a capture file (vr_client/record/replay.h).
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stereo/base/clock.h"
#include "stereo/link/frame_receiver.h"

namespace farshade {

/// What goes with a request.
struct RequestParts {
  /// The messages that follow it: the PlaneSlices or AskSlices that it announces.
  std::span<const std::vector<std::byte>> messages{};
  /// The masks that were reprojected to its views; only their blocks that are not asked for are known. Null:
  /// all is asked for.
  const PerEye<EyeMask>* reprojected = nullptr;
};

/// Bytes of datagrams since the link was made, with everything that is sent over UDP.
struct LinkTraffic {
  std::uint64_t up = 0;    ///< sent to the server
  std::uint64_t down = 0;  ///< received from it
};

class ServerConnection {
 public:
  virtual ~ServerConnection() = default;

  /// Sends a request. `requested_at` is the display time of the frame that makes it. Without a session
  /// nothing is sent or recorded.
  virtual void request(const FrameRequest& request, Time requested_at, const RequestParts& parts = {}) = 0;

  /// Receives until all of the answer to `frame` has come or `patience` is over. True if all has come.
  virtual bool wait_for(FrameId frame, Duration patience) = 0;

  /// Whether a request may ask for a part of its views, and whether pairs of the cube mask may be requested.
  /// Not while a capture is written or replayed: a capture holds the server's messages about whole views.
  [[nodiscard]] virtual bool takes_parts() const = 0;

  [[nodiscard]] virtual const FrameReceiver& receiver() const = 0;

  /// Why the server refuses this client for good; no value while it does not.
  [[nodiscard]] virtual const std::optional<Error>& refused() const = 0;

  /// Since when the server has answered nothing though it was asked, or greeted; no value while it answers.
  [[nodiscard]] virtual std::optional<Time> silent_since() const { return std::nullopt; }

  /// Why the server has ended the last session, as a sentence; no value if it did not, or while a session is
  /// open.
  [[nodiscard]] virtual std::optional<std::string> goodbye() const { return std::nullopt; }

  /// No value if no network carries the messages.
  [[nodiscard]] virtual std::optional<LinkTraffic> traffic() const { return std::nullopt; }

  /// The time spent so far on opening, decoding and assembling messages, without waits.
  [[nodiscard]] virtual Duration busy() const = 0;
};

}  // namespace farshade
