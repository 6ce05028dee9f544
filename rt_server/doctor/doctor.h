/// `rt_server doctor`: what a server needs of this machine, and what to do where it is missing. Serves nobody
/// and changes nothing.
#pragma once

#include <string>

#include "stereo/doctor/finding.h"

namespace CLI {
class App;
}

namespace farshade {

struct ServerDoctorOptions {
  std::string ring;  ///< empty for default_ring_path()
  std::string listen = "127.0.0.1:7447";
  std::string scene;  ///< empty: none is loaded
};

/// Adds the subcommand `doctor` and its options to the program. `options` must outlive the parsing.
void add_doctor(CLI::App& program, ServerDoctorOptions& options);

[[nodiscard]] Findings examine(const ServerDoctorOptions& options);

}  // namespace farshade
