/// `vr_client doctor`: checks what a client needs on this machine and at its server, and names a cure for
/// each problem. It draws nothing and opens no window.
#pragma once

#include <string>

#include "stereo/doctor/checks.h"
#include "stereo/scene/lighting.h"

namespace CLI {
class App;
}

namespace farshade {

struct ClientDoctorOptions {
  std::string key;     ///< file; empty: default_key_path()
  std::string server;  ///< empty: no server is contacted
  bool insecure = false;
  std::string scene;  ///< empty: the server may serve any scene
  Lighting lighting;  ///< of the scene
};

/// Adds the subcommand `doctor` and its options to the program. `options` must outlive the parsing.
void add_doctor(CLI::App& program, ClientDoctorOptions& options);

[[nodiscard]] Findings examine(const ClientDoctorOptions& options);

}  // namespace farshade
