/// `rt_server keygen`: makes a key for one client, writes it to a file for the client and adds it to the
/// server's key ring.
#pragma once

#include <string>

#include "stereo/base/expected.h"

namespace CLI {
class App;
}

namespace farshade {

struct KeygenOptions {
  std::string name;
  std::string key;   ///< the client's key file; empty for default_key_path()
  std::string ring;  ///< the server's key ring; empty for default_ring_path()
};

/// Adds the subcommand `keygen` and its options to `program`. `options` must outlive the parsing.
void add_keygen(CLI::App& program, KeygenOptions& options);

/// Writes both files, and returns a text for the user that names the next step. If one file cannot be
/// written, the other does not change.
[[nodiscard]] Expected<std::string> keygen(const KeygenOptions& options);

}  // namespace farshade
