#include "rt_server/core/serve.h"

#include <algorithm>

namespace farshade {
namespace {

constexpr Duration kLongWait = std::chrono::seconds(60);  // wake() ends it earlier

}  // namespace

Serving::Serving(ServerCore& core)
    : core_(core),
      network_([&core](const std::stop_token& stop) {
        while (!stop.stop_requested()) {
          const std::optional<Time> due = core.next_send();
          core.receive(due ? std::clamp(*due - core.clock().now(), Duration::zero(), kLongWait) : kLongWait);
          core.send_due();
        }
      }),
      worker_([&core](const std::stop_token& stop) {
        while (core.wait_for_work(stop)) core.work();
      }) {}

Serving::~Serving() {
  network_.request_stop();
  worker_.request_stop();
  core_.wake();
}

}  // namespace farshade
