#include "stereo/base/stop_signal.h"

#include <ctime>

#include "stereo/base/check.h"

namespace farshade {
StopSignal::StopSignal(Hangup hangup) {
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGTERM);
  sigemptyset(&requests_);
  sigaddset(&requests_, SIGUSR1);
  if (hangup == Hangup::IsARequest) sigaddset(&requests_, SIGHUP);
  check_eq(pthread_sigmask(SIG_BLOCK, &signals_, &before_), 0, "signals can be blocked");
  check_eq(pthread_sigmask(SIG_BLOCK, &requests_, nullptr), 0, "signals can be blocked");
}

StopSignal::~StopSignal() {
  sigset_t opened;
  sigemptyset(&opened);
  for (const int signal : {SIGINT, SIGTERM})
    if (sigismember(&before_, signal) == 0) sigaddset(&opened, signal);
  pthread_sigmask(SIG_UNBLOCK, &opened, nullptr);
}

void StopSignal::wait(const std::function<void()>& report, const std::function<void()>& reload,
                      const std::function<void()>& look) {
  constexpr timespec kSecond{.tv_sec = 1, .tv_nsec = 0};
  sigset_t all;
  sigorset(&all, &signals_, &requests_);
  while (came_ == 0) {
    const int signal = sigtimedwait(&all, nullptr, &kSecond);
    if (signal < 0)
      look();
    else if (signal == SIGUSR1)
      report();
    else if (signal == SIGHUP)
      reload();
    else
      let_the_next_one_through(signal);
  }
}

bool StopSignal::has_come() {
  const timespec at_once{};
  if (came_ != 0) return true;
  if (const int signal = sigtimedwait(&signals_, nullptr, &at_once); signal > 0)
    let_the_next_one_through(signal);
  return came_ != 0;
}

void StopSignal::let_the_next_one_through(int came) {
  came_ = came;
  check_eq(pthread_sigmask(SIG_UNBLOCK, &signals_, nullptr), 0, "signals can be let through");
}

}  // namespace farshade
