/// Way: how a mode's frames come by their light. The loop (session.cpp) begins a frame and walks three steps;
/// each mode is one file beside this one with its three steps in it, and the stages that modes share are
/// exchange.h and the renderer's.
#pragma once

#include <memory>

#include "vr_client/session.h"

namespace farshade {

/// A frame that has begun: what it is to show, and what it is steered by.
struct Moment {
  const TraceRequest& shown;
  const SceneState& state;
  Duration period;  ///< the display's
  const Steering& steering;
};

/// What a frame was shown with. What it refers to stays until the next frame begins.
struct Seen {
  DrawTimes drawn;
  ShownAs as = ShownAs::Shaded;
  bool start_up = false;                ///< nothing of what it needs has come yet
  std::span<const MaskInHand> masks{};  ///< that it was drawn with, newest first
  const ReceivedFrame* newest = nullptr;
  std::optional<Duration> age{};
  PerEye<double> black{};
  Duration decoding{};  ///< of what came, beyond what the link does
};

class Way {
 public:
  virtual ~Way() = default;

  /// Asks the server, where the mode has one, and says for what. It stays until the next call.
  virtual const TraceRequest* request(const Moment& moment) = 0;

  /// Takes in what has come, or traces.
  virtual void collect(const Moment& moment) = 0;

  /// Leaves the picture in the renderer.
  virtual Seen draw(const Moment& moment) = 0;
};

// Each in its own file. What the mode needs of `session` (link, own tracer) is there, or no light casts
// shadows. References are kept.
[[nodiscard]] std::unique_ptr<Way> make_hybrid(const Session& session);
[[nodiscard]] std::unique_ptr<Way> make_client_positions(const Session& session);
[[nodiscard]] std::unique_ptr<Way> make_server_gbuffer(const Session& session);
[[nodiscard]] std::unique_ptr<Way> make_remote(const Session& session);
[[nodiscard]] std::unique_ptr<Way> make_delta(const Session& session);
[[nodiscard]] std::unique_ptr<Way> make_local(const Session& session);
[[nodiscard]] std::unique_ptr<Way> make_full(const Session& session);

/// That of session.mode.
[[nodiscard]] std::unique_ptr<Way> make_way(const Session& session);

}  // namespace farshade
