#include "stereo/base/stop_signal.h"

#include <ctime>

#include "stereo/base/check.h"

namespace farshade {

StopSignal::StopSignal() {
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGTERM);
  check_eq(pthread_sigmask(SIG_BLOCK, &signals_, nullptr), 0, "signals can be blocked");
}

void StopSignal::wait() {
  if (came_) return;
  int signal = 0;
  check_eq(sigwait(&signals_, &signal), 0, "a stop signal can be waited for");
  let_the_next_one_through();
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
