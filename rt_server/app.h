/// Serving: loads the scene, opens the port and answers requests until a signal arrives.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rt_server/sessions/sessions.h"
#include "stereo/base/expected.h"
#include "stereo/base/stop_signal.h"
#include "stereo/plan/scene_plan.h"
#include "stereo/scene/lighting.h"

namespace farshade {

struct ServeOptions {
  std::string scene;
  Lighting lighting;
  std::vector<std::string> listen{"127.0.0.1:7447"};
  std::string ring;         ///< key ring file; empty for default_ring_path()
  bool scene_fetch = true;  ///< clients without the scene may fetch its files
  bool announce = true;     ///< tell the local network the addresses that are not of this machine only
  bool insecure = false;    ///< accept any client on this machine, without encryption
  std::string net;          ///< simulated impairment of arriving datagrams (parse_link_model); empty for none
  SessionLimits limits;
  std::uint32_t most_pixels = Welcome{}.most_pixels;  ///< maximum of an eye's view in a request
  PlanOptions plan;
  std::string ready_file;  ///< for scripts (kReadyListening, kReadyNoShadows); empty for none
};

/// The lines of the ready file: the first, a space and an address, for each address in the order of the
/// options; or the second alone.
inline constexpr std::string_view kReadyListening = "listening";
inline constexpr std::string_view kReadyNoShadows = "no-shadows";

/// Serves until SIGINT or SIGTERM arrives. Writes results to stdout and the log to stderr. Prints its
/// counters at the end and on every SIGUSR1. Reads the key ring again on every SIGHUP, and when its file has
/// changed. If `options.plan`
/// only asks for the plan, prints the plan instead.
///
/// Removes an old ready file first. Writes the new one atomically: when the port is open and clients can
/// connect, or when the scene has no light that casts shadows. In the latter case there is nothing to serve:
/// with a ready file the call ends at once and succeeds, without one it fails.
[[nodiscard]] Expected<void> serve(const ServeOptions& options, StopSignal& stop);

}  // namespace farshade
