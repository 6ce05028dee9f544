/// BlockingCalls: calls that may block for ever, on a thread of their own, so that the caller can give one
/// up.
#pragma once

#include <functional>
#include <memory>
#include <thread>

namespace farshade::openxr {

class BlockingCalls {
 public:
  BlockingCalls();
  BlockingCalls(const BlockingCalls&) = delete;
  BlockingCalls& operator=(const BlockingCalls&) = delete;
  ~BlockingCalls();

  /// Runs `call` on the thread and waits for it. While it blocks, asks `goes_on` every 100 ms, on the
  /// caller's thread. Returns false if `goes_on` did; then the call runs on by itself, and no other call may
  /// follow. So `call` must own what it uses.
  [[nodiscard]] bool run(std::function<void()> call, const std::function<bool()>& goes_on);

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;  ///< with the thread
  std::thread thread_;
};

}  // namespace farshade::openxr
