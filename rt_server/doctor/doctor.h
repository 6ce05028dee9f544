/// `rt_server doctor`: checks what a server needs on this machine, and names a cure for each problem. It
/// serves no client and changes nothing.
#pragma once

#include <string>

#include "stereo/doctor/checks.h"

namespace CLI {
class App;
}

namespace farshade {

struct ServerDoctorOptions {
  std::string ring;  ///< empty: default_ring_path()
  std::string listen = "127.0.0.1:7447";
  std::string scene;  ///< empty: no scene is loaded
};

/// Adds the subcommand `doctor` and its options to the program. `options` must outlive the parsing.
void add_doctor(CLI::App& program, ServerDoctorOptions& options);

[[nodiscard]] Findings examine(const ServerDoctorOptions& options);

}  // namespace farshade
