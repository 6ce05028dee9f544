/// What the program rt_server does when it serves: load the scene, open the port, answer until told to stop.
#pragma once

#include <string>

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
};

/// Results go to stdout, the log to stderr. Ends when `stop` says so. Says its counters at the end, and on
/// SIGUSR1. Where the plan is only to be told, it says the plan in words instead.
[[nodiscard]] Expected<void> serve(const ServeOptions& options, StopSignal& stop);

}  // namespace farshade
