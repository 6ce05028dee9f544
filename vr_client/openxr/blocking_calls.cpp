#include "vr_client/openxr/blocking_calls.h"

#include <condition_variable>
#include <mutex>

#include "stereo/base/check.h"

namespace farshade::openxr {

struct BlockingCalls::Shared {
  std::mutex mutex;
  std::condition_variable changed;
  std::function<void()> call;  ///< empty when it has returned
  bool ends = false;

  void serve() {
    std::unique_lock lock(mutex);
    for (;;) {
      changed.wait(lock, [this] { return ends || call; });
      if (ends) return;
      lock.unlock();
      call();
      lock.lock();
      call = nullptr;
      changed.notify_all();
    }
  }
};

BlockingCalls::BlockingCalls()
    : shared_(std::make_shared<Shared>()), thread_([shared = shared_] { shared->serve(); }) {}

BlockingCalls::~BlockingCalls() {
  {
    const std::scoped_lock lock(shared_->mutex);
    shared_->ends = true;
  }
  shared_->changed.notify_all();
  if (thread_.joinable()) thread_.join();
}

bool BlockingCalls::run(std::function<void()> call, const std::function<bool()>& goes_on) {
  constexpr auto kLook = std::chrono::milliseconds(100);
  check(thread_.joinable(), "no call follows one that was given up");
  std::unique_lock lock(shared_->mutex);
  shared_->call = std::move(call);
  shared_->changed.notify_all();
  const auto has_returned = [this] { return !shared_->call; };
  while (!shared_->changed.wait_for(lock, kLook, has_returned)) {
    lock.unlock();
    const bool waits_on = goes_on();
    lock.lock();
    if (waits_on) continue;
    if (!has_returned()) thread_.detach();
    return has_returned();
  }
  return true;
}

}  // namespace farshade::openxr
