/// SIGINT and SIGTERM as something to wait for, instead of something that interrupts.
#pragma once

#include <csignal>

namespace farshade {

class StopSignal {
 public:
  /// Blocks both signals in this thread and in every thread that it starts from now on: make it before them.
  StopSignal();

  /// Returns when one of them has come.
  void wait() const;

 private:
  sigset_t signals_;
};

}  // namespace farshade
