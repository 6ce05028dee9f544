#include "rt_server/log/log_sink.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <climits>
#include <string>

namespace farshade {
namespace {

/// Whether the file takes up to PIPE_BUF bytes without waiting.
bool takes_now(int file) {
  pollfd ready{.fd = file, .events = POLLOUT, .revents = 0};
  return poll(&ready, 1, 0) == 1 && (ready.revents & POLLOUT) != 0;
}

}  // namespace

bool write_now(int file, const std::string& text) {
  return takes_now(file) && write(file, text.data(), std::min<std::size_t>(text.size(), PIPE_BUF)) > 0;
}

void LogSink::sink_it_(const spdlog::details::log_msg& message) {
  if (dropped_ > 0 &&
      write_now(file_, fmt::format("{} lines of the log were dropped: they could not be written at once\n",
                                   dropped_)))
    dropped_ = 0;
  spdlog::memory_buf_t line;
  formatter_->format(message, line);
  if (dropped_ > 0 || !write_now(file_, std::string(line.data(), line.size()))) ++dropped_;
}

}  // namespace farshade
