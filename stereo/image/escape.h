/// The one way out of libpng and libjpeg on error: a long jump to the step that called them.
/// A jump runs no destructors, so a step holds only trivial objects while the library runs (buffers are made
/// by its caller), and the callbacks do as well.
#pragma once

#include <csetjmp>

namespace farshade {

struct Escape {
  std::jmp_buf landing;
  char reason[256] = "";  ///< set before the jump; JMSG_LENGTH_MAX of libjpeg is 200
};

/// Runs `step`. False if it jumped: `escape.reason` says why.
template <class Step>
[[nodiscard]] bool runs_through(Escape& escape, const Step& step) {
  if (setjmp(escape.landing) != 0) return false;
  step();
  return true;
}

}  // namespace farshade
