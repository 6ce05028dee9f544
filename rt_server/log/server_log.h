/// ServerLog: the log on standard error, and what the server says on standard output. A thread of its own
/// writes both, so that neither a reader that has stopped nor a disk that hangs holds up another thread.
#pragma once

#include <memory>
#include <string_view>

namespace spdlog::details {
class thread_pool;
}

namespace farshade {

class ServerLog {
 public:
  /// Becomes the default log of the process.
  ServerLog();
  ServerLog(const ServerLog&) = delete;
  ServerLog& operator=(const ServerLog&) = delete;
  /// Writes what is left. If that takes more than a second, ends the process: a thread that waits for a disk
  /// cannot be ended otherwise.
  ~ServerLog();

 private:
  std::shared_ptr<spdlog::details::thread_pool> writer_;
};

/// Returns when everything is written, or after a second.
void flush_log();

/// Writes a line to standard output. Only while there is a ServerLog.
void say(std::string_view line);

}  // namespace farshade
