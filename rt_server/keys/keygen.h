/// `rt_server keygen`: a key for one client, in a file of its own and in the server's ring.
#pragma once

#include <string>

#include "stereo/base/expected.h"

namespace CLI {
class App;
}

namespace farshade {

struct KeygenOptions {
  std::string name;
  std::string key;   ///< the client's file; empty for default_key_path()
  std::string ring;  ///< empty for default_ring_path()
};

/// Adds the subcommand `keygen` and its options to the program. `options` must outlive the parsing.
void add_keygen(CLI::App& program, KeygenOptions& options);

/// Makes both files and says what to do next. If one cannot be made, the other is as it was.
[[nodiscard]] Expected<std::string> keygen(const KeygenOptions& options);

}  // namespace farshade
