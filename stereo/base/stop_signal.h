/// StopSignal: a program waits for SIGINT and SIGTERM, or polls them, instead of being interrupted by them.
/// After the first of them, the next one ends the program at once, as by default. SIGUSR1 asks a waiting
/// program to report its state, and SIGHUP asks one that wants it to read its files again.
#pragma once

#include <csignal>
#include <cstdint>
#include <functional>
#include <thread>

namespace farshade {

class StopSignal {
 public:
  /// What SIGHUP does, which also comes when the terminal of the program is closed.
  enum class Hangup : std::uint8_t { EndsTheProgram, IsARequest };

  /// Blocks these signals in this thread and in every thread that it starts from now on. So construct it
  /// before other threads, and call it from this thread only.
  explicit StopSignal(Hangup hangup = Hangup::EndsTheProgram);
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;
  /// From here on, SIGINT and SIGTERM do in this thread what they did before.
  ~StopSignal();

  /// The exit status of a program that a signal has ended.
  enum class Ending : std::uint8_t {
    Success,   ///< 0: it was to run until then
    BySignal,  ///< 128 and the signal's number, as a shell gives it: it has not done its work
  };

  /// While it lives, SIGINT and SIGTERM end the process at once: for long work that nobody polls and that
  /// leaves nothing behind. The other functions must not be called meanwhile.
  class EndsAtOnce {
   public:
    explicit EndsAtOnce(StopSignal& stop, Ending ending);

   private:
    std::jthread waits_;
  };

  /// Returns when SIGINT or SIGTERM has arrived. Calls `report` for each SIGUSR1, `reload` for each SIGHUP
  /// that is a request, and `look` once a second.
  void wait(
      const std::function<void()>& report = [] {}, const std::function<void()>& reload = [] {},
      const std::function<void()>& look = [] {});

  /// Whether SIGINT or SIGTERM has arrived by now.
  [[nodiscard]] bool has_come();

  /// What a shell gives for a program that the signal has ended: 130 for SIGINT, 143 for SIGTERM. 0 while
  /// neither of them has arrived.
  [[nodiscard]] int exit_status() const { return came_ == 0 ? 0 : 128 + came_; }

 private:
  void let_the_next_one_through(int came);

  sigset_t signals_;   ///< SIGINT and SIGTERM
  sigset_t requests_;  ///< SIGUSR1, and SIGHUP if it is one
  sigset_t before_;    ///< the signals that were blocked before
  int came_ = 0;       ///< the signal that has arrived
};

}  // namespace farshade
