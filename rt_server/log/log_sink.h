/// LogSink: writes log lines to a file descriptor without waiting for whoever reads them. A full pipe (a
/// pager, a service that hangs, a terminal that was stopped) would otherwise hold up the thread that logs,
/// and that is the one of the network. Whoever has a key can fill a pipe by coming and going.
#pragma once

#include <spdlog/sinks/base_sink.h>

#include <cstdint>
#include <mutex>
#include <string>

namespace farshade {

/// Writes `text`, or its first PIPE_BUF bytes, if the file takes it without waiting.
bool write_now(int file, const std::string& text);

class LogSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  /// Does not close `file`.
  explicit LogSink(int file) : file_(file) {}

 protected:
  /// Drops the line if the file does not take it at once. The next line that is written says how many were
  /// dropped. Lines are cut off after PIPE_BUF bytes: a pipe that takes anything takes as many.
  void sink_it_(const spdlog::details::log_msg& message) override;
  void flush_() override {}

 private:
  int file_;
  std::uint64_t dropped_ = 0;
};

}  // namespace farshade
