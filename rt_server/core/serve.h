/// The server's two threads: one hears the network, one traces. They end when the value does.
#pragma once

#include <thread>

#include "rt_server/core/server_core.h"

namespace farshade {

class Serving {
 public:
  /// Serves from now on. `core` outlives it.
  explicit Serving(ServerCore& core);
  Serving(const Serving&) = delete;
  Serving& operator=(const Serving&) = delete;
  /// Ends both threads; a frame that is being traced is finished first.
  ~Serving();

 private:
  ServerCore& core_;
  std::jthread network_, worker_;
};

}  // namespace farshade
