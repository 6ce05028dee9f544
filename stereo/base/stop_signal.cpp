#include "rt_server/stop_signal.h"

#include "stereo/base/check.h"

namespace farshade {

StopSignal::StopSignal() {
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGTERM);
  check_eq(pthread_sigmask(SIG_BLOCK, &signals_, nullptr), 0, "signals can be blocked");
}

void StopSignal::wait() const {
  int signal = 0;
  check_eq(sigwait(&signals_, &signal), 0, "a stop signal can be waited for");
}

}  // namespace farshade
