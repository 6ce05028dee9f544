#include "vr_client/report/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace farshade {

void Progress::show(std::uint32_t done) const {
  const bool terminal = isatty(STDERR_FILENO) != 0;
  const std::uint32_t step = terminal ? 1 : std::max(frames_ / 10, 1u);
  if (done % step != 0 && done != frames_) return;
  const double left_s = seconds_of(watch_.elapsed()) / done * (frames_ - done);
  fmt::print(stderr, "{}frame {} of {}, about {:.0f} s left{}", terminal ? "\r" : "", done, frames_, left_s,
             terminal && done != frames_ ? "   " : "   \n");
  std::fflush(stderr);
}

}  // namespace farshade
