#include "stereo/base/stop_signal.h"

#include <algorithm>
#include <cstdlib>
#include <ctime>

#include "stereo/base/check.h"
#include "stereo/base/clock.h"

namespace farshade {
namespace {

constexpr Duration kLook = std::chrono::seconds(1);

}  // namespace

StopSignal::EndsAtOnce::EndsAtOnce(StopSignal& stop, Ending ending)
    : waits_([&stop, ending](const std::stop_token& over) {
        constexpr timespec kStep{.tv_sec = 0, .tv_nsec = 20'000'000};
        while (!over.stop_requested())
          if (const int signal = sigtimedwait(&stop.signals_, nullptr, &kStep); signal > 0)
            std::_Exit(ending == Ending::Success ? EXIT_SUCCESS : 128 + signal);
      }) {}

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
  const SteadyClock clock;
  sigset_t all;
  sigorset(&all, &signals_, &requests_);
  // Requests come before SIGTERM, whose number is higher, so it is asked for alone, too.
  for (Time next_look = clock.now() + kLook; !has_come();) {
    const Duration left = std::max(next_look - clock.now(), Duration::zero());
    const timespec wait{.tv_sec = left / std::chrono::seconds(1),
                        .tv_nsec = (left % std::chrono::seconds(1)).count()};
    const int signal = sigtimedwait(&all, nullptr, &wait);
    if (clock.now() >= next_look) {  // also if signals come more often
      look();
      next_look = clock.now() + kLook;
    }
    if (signal < 0) continue;
    if (signal == SIGUSR1)
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
