/// SIGINT and SIGTERM as something to wait for or to ask about, instead of something that interrupts.
/// Once the first has come the next one ends the program at once, as it would without this.
#pragma once

#include <csignal>

namespace farshade {

class StopSignal {
 public:
  /// Blocks both signals in this thread and in every thread that it starts from now on: make it before them,
  /// and ask it from this thread.
  StopSignal();

  /// Returns when one of them has come.
  void wait();

  /// Whether one has come by now.
  [[nodiscard]] bool has_come();

 private:
  void let_the_next_one_through();

  sigset_t signals_;
  bool came_ = false;
};

}  // namespace farshade
