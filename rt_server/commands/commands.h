/// The subcommands of rt_server. Options must outlive the parsing.
///
/// `doctor` checks what a server needs on this machine, and names a cure for each problem. It serves no
/// client and changes nothing. `keygen` makes a key for one client, writes it to a file for the client and
/// adds it to the server's key ring. `pair` lets a new client bring its own key.
/// `inspect` says what a scene file has.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "stereo/base/stop_signal.h"
#include "stereo/doctor/checks.h"
#include "stereo/scene/lighting.h"

namespace CLI {
class App;
}

namespace farshade {

struct ServerDoctorOptions {
  std::string ring;  ///< empty: default_ring_path()
  std::vector<std::string> listen{"127.0.0.1:7447"};
  std::string scene;  ///< empty: no scene is loaded
  Lighting lighting;  ///< of the scene
};

/// Adds the subcommand `doctor` and its options to the program.
void add_doctor(CLI::App& program, ServerDoctorOptions& options);

[[nodiscard]] Findings examine(const ServerDoctorOptions& options);

struct InspectOptions {
  std::string file;
  Lighting lighting;  ///< as if it were served
  bool json = false;
};

/// Adds the subcommand `inspect` and its options to the program.
void add_inspect(CLI::App& program, InspectOptions& options);

/// Triangles, size, lights, memory, and what was chosen or left out: as text or as JSON. Fails if the file is
/// refused.
[[nodiscard]] Expected<std::string> inspect(const InspectOptions& options);

struct ServerPairOptions {
  std::string ring;  ///< the server's key ring; empty for default_ring_path()
  std::vector<std::string> listen{"0.0.0.0:7448"};
  std::string address;  ///< host to show in the code; empty: the address of this machine
  double minutes = 5;   ///< life of the code
};

/// Adds the subcommand `pair` and its options to `program`.
void add_pair(CLI::App& program, ServerPairOptions& options);

/// Prints a code and waits until a client with it has brought its key, or until it is too old or `stop`
/// has come.
[[nodiscard]] Expected<void> pair_client(const ServerPairOptions& options, StopSignal& stop);

struct KeygenOptions {
  std::string name;
  std::string key;    ///< the client's key file; empty for default_key_path()
  std::string ring;   ///< the server's key ring; empty for default_ring_path()
  std::string until;  ///< KeyLimits of the key in the ring: a day for parse_day; empty or 0 for none
  std::uint64_t sessions = 0, bytes_per_second = 0;
};

/// Adds the subcommand `keygen` and its options to `program`.
void add_keygen(CLI::App& program, KeygenOptions& options);

/// Writes both files, and returns a text for the user that names the next step. If one file cannot be
/// written, the other does not change.
[[nodiscard]] Expected<std::string> keygen(const KeygenOptions& options);

}  // namespace farshade
