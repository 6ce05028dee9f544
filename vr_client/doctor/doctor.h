/// `vr_client doctor`: what a client needs of this machine and of its server, and what to do where it is
/// missing. Draws nothing and opens no window.
#pragma once

#include <string>

#include "stereo/doctor/finding.h"

namespace CLI {
class App;
}

namespace farshade {

struct ClientDoctorOptions {
  std::string key;     ///< file; empty for default_key_path()
  std::string server;  ///< empty: none is asked
  bool insecure = false;
  std::string scene;  ///< empty: any scene of the server's is right
};

/// Adds the subcommand `doctor` and its options to the program. `options` must outlive the parsing.
void add_doctor(CLI::App& program, ClientDoctorOptions& options);

[[nodiscard]] Findings examine(const ClientDoctorOptions& options);

}  // namespace farshade
