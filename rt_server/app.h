/// What the program rt_server does when it serves: load the scene, open the port, answer until told to stop.
#pragma once

#include <string>
#include <string_view>

#include "rt_server/core/sessions.h"
#include "stereo/base/expected.h"
#include "stereo/base/stop_signal.h"
#include "stereo/plan/scene_plan.h"

namespace farshade {

struct ServeOptions {
  std::string scene;
  std::string listen = "127.0.0.1:7447";
  std::string ring;       ///< of keys; empty for default_ring_path()
  bool insecure = false;  ///< anyone on this machine, unsealed
  std::string net;        ///< the network towards the server, as parse_link_model has it; empty for as it is
  SessionLimits limits;
  std::uint32_t most_pixels = Welcome{}.most_pixels;  ///< of an eye that a client may ask for
  PlanOptions plan;
  std::string ready_file;  ///< for scripts (kReadyListening, kReadyNoShadows); empty for none
};

/// The one line that the ready file gets: the first, a space and the address, or the second.
inline constexpr std::string_view kReadyListening = "listening";
inline constexpr std::string_view kReadyNoShadows = "no-shadows";

/// Serves until SIGINT or SIGTERM arrives. Writes results to stdout and the log to stderr. Prints its
/// counters at the end and on every SIGUSR1. If `options.plan` only asks for the plan, prints the plan
/// instead.
///
/// Removes an old ready file first. Writes the new one atomically: when the port is open and clients can
/// connect, or when the scene has no light that casts shadows. In the latter case there is nothing to serve:
/// with a ready file the call ends at once and succeeds, without one it fails.
[[nodiscard]] Expected<void> serve(const ServeOptions& options, StopSignal& stop);

}  // namespace farshade
