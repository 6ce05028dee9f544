#include "stereo/base/stop_signal.h"

#include <ctime>

#include "stereo/base/check.h"

namespace farshade {
namespace {

sigset_t with_question(sigset_t signals) {
  sigaddset(&signals, SIGUSR1);
  return signals;
}

}  // namespace

StopSignal::StopSignal() {
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGTERM);
  const sigset_t all = with_question(signals_);
  check_eq(pthread_sigmask(SIG_BLOCK, &all, &before_), 0, "signals can be blocked");
}

StopSignal::~StopSignal() {
  sigset_t opened;
  sigemptyset(&opened);
  for (const int signal : {SIGINT, SIGTERM})
    if (sigismember(&before_, signal) == 0) sigaddset(&opened, signal);
  pthread_sigmask(SIG_UNBLOCK, &opened, nullptr);
}

void StopSignal::wait(const std::function<void()>& report) {
  const sigset_t all = with_question(signals_);
  while (!came_) {
    int signal = 0;
    check_eq(sigwait(&all, &signal), 0, "a signal can be waited for");
    if (signal == SIGUSR1)
      report();
    else
      let_the_next_one_through();
  }
}

bool StopSignal::has_come() {
  const timespec at_once{};
  if (!came_ && sigtimedwait(&signals_, nullptr, &at_once) > 0) let_the_next_one_through();
  return came_;
}

void StopSignal::let_the_next_one_through() {
  came_ = true;
  check_eq(pthread_sigmask(SIG_UNBLOCK, &signals_, nullptr), 0, "signals can be let through");
}

}  // namespace farshade
