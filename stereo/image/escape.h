/// Error handling of libpng and libjpeg: their error callback jumps back to the function that called them.
/// A long jump runs no destructors. So that function and the callbacks have only trivial objects while the
/// library runs; their caller owns the buffers.
#pragma once

#include <csetjmp>

namespace farshade {

struct Escape {
  std::jmp_buf landing;
  char reason[256] = "";  ///< set before the jump; JMSG_LENGTH_MAX of libjpeg is 200
};

/// Runs `step`. Returns false if it jumped, with the error text in `escape.reason`.
template <class Step>
[[nodiscard]] bool runs_through(Escape& escape, const Step& step) {
  if (setjmp(escape.landing) != 0) return false;
  step();
  return true;
}

}  // namespace farshade
