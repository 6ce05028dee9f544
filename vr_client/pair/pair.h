/// `vr_client pair CODE`: makes a key and brings it to the server that shows the code.
#pragma once

#include <string>

#include "stereo/base/expected.h"

namespace CLI {
class App;
}

namespace farshade {

struct ClientPairOptions {
  std::string code;  ///< pairing_code.h
  std::string key;   ///< file to make; empty: default_key_path()
  std::string name;  ///< of the key in the server's ring and log; empty: made from this machine's name
};

/// Adds the subcommand `pair` and its options to the program. `options` must outlive the parsing.
void add_pair(CLI::App& program, ClientPairOptions& options);

/// Returns a text for the user that names the next step. Refuses (Unavailable) a key file that exists. After
/// a failure there is no key file.
[[nodiscard]] Expected<std::string> pair_with_server(const ClientPairOptions& options);

/// `machine` with hyphens in place of what a key's name may not have.
[[nodiscard]] std::string key_name_of(std::string_view machine);

}  // namespace farshade
