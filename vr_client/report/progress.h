/// Progress: prints how many frames of a run are done.
#pragma once

#include <cstdint>

#include "stereo/base/clock.h"

namespace farshade {

/// Prints to standard error. On a terminal one line is overwritten with each frame; elsewhere a line follows
/// each tenth of the run.
class Progress {
 public:
  explicit Progress(std::uint32_t frames) : frames_(frames) {}

  void show(std::uint32_t done) const;

 private:
  std::uint32_t frames_;
  Stopwatch watch_;
};

}  // namespace farshade
