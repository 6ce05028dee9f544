#include "stereo/base/check.h"

#include <cstdio>
#include <cstdlib>

namespace farshade {

void check_failed(std::string_view what, const std::string& detail, CallPlace where) {
  std::fprintf(stderr, "%s:%u: check failed: %.*s%s%s\n", where.file, where.line,
               static_cast<int>(what.size()), what.data(), detail.empty() ? "" : ": ", detail.c_str());
  std::abort();
}

}  // namespace farshade
