/// Tests whose long run finds faults that a short one may miss do the long run with FARSHADE_NIGHTLY=1,
/// otherwise the short one. Both run the same body with other counts.
#pragma once

#include <cstdlib>
#include <string_view>

namespace farshade {

/// `long_run` if the environment variable FARSHADE_NIGHTLY is 1, otherwise `usual`.
template <class Count>
[[nodiscard]] Count nightly(Count usual, Count long_run) {
  const char* const set = std::getenv("FARSHADE_NIGHTLY");
  return set != nullptr && std::string_view(set) == "1" ? long_run : usual;
}

}  // namespace farshade
