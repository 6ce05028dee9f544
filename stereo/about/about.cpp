#include "stereo/about/about.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace farshade {

extern const char kCommit[];  ///< cmake/commit.cmake defines it

std::string about(const std::string& program, const std::vector<std::string>& protocols,
                  const std::vector<std::string>& loaded) {
  const std::string commit = kCommit[0] == '\0' ? std::string() : fmt::format(", commit {}", kCommit);
  return fmt::format(
      "{} {}\n"
      "build: {}, {}{}\n"
      "protocols: {}\n"
      "built with: {}\n"
      "loaded: {}",
      program, FARSHADE_VERSION, FARSHADE_BUILD_TYPE, FARSHADE_COMPILER, commit, fmt::join(protocols, ", "),
      FARSHADE_LIBRARIES, fmt::join(loaded, ", "));
}

}  // namespace farshade
