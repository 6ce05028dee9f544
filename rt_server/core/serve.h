/// Serving: the server's two threads. One receives and sends datagrams, the other answers requests.
#pragma once

#include <thread>

#include "rt_server/core/server_core.h"

namespace farshade {

class Serving {
 public:
  /// Starts both threads. `core` must outlive this object.
  explicit Serving(ServerCore& core);
  Serving(const Serving&) = delete;
  Serving& operator=(const Serving&) = delete;
  /// Ends both threads. Waits until the answer in work is finished.
  ~Serving();

 private:
  ServerCore& core_;
  std::jthread network_, worker_;
};

}  // namespace farshade
