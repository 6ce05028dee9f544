/// SIGINT and SIGTERM as something to wait for or to ask about, instead of something that interrupts.
/// Once the first has come the next one ends the program at once, as it would without this.
/// SIGUSR1 ends nothing: it asks a program that waits how things stand.
#pragma once

#include <csignal>
#include <functional>

namespace farshade {

class StopSignal {
 public:
  /// Blocks all three signals in this thread and in every thread that it starts from now on: make it before
  /// them, and ask it from this thread.
  StopSignal();

  /// Returns when SIGINT or SIGTERM has come. Calls `tell` whenever SIGUSR1 comes.
  void wait(const std::function<void()>& tell = [] {});

  /// Whether SIGINT or SIGTERM has come by now.
  [[nodiscard]] bool has_come();

 private:
  void let_the_next_one_through();

  sigset_t signals_;  ///< SIGINT and SIGTERM
  bool came_ = false;
};

}  // namespace farshade
