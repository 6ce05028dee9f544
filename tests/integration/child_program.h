/// A program of ours as a child process: its standard output line by line, its end, and what it said until
/// then.
#pragma once

#include <sys/types.h>

#include <csignal>
#include <optional>
#include <string>
#include <vector>

namespace farshade {

class ChildProgram {
 public:
  /// Starts `arguments[0]` with the rest as its arguments.
  explicit ChildProgram(const std::vector<std::string>& arguments);
  ChildProgram(const ChildProgram&) = delete;
  ChildProgram& operator=(const ChildProgram&) = delete;
  /// Kills it where it still runs.
  ~ChildProgram();

  /// The next line of standard output that begins with `prefix`, without it; nothing when output ends first.
  std::optional<std::string> line_after(const std::string& prefix);

  void send(int signal) const { kill(pid_, signal); }

  /// Waits for its end: the exit status, or minus the signal that ended it.
  int wait();

  /// What it wrote to standard error; whole once wait() has returned.
  [[nodiscard]] std::string errors();

 private:
  std::optional<std::string> next_line();

  pid_t pid_ = -1;
  int output_ = -1, errors_ = -1;  ///< read ends
  std::string unread_;
};

}  // namespace farshade
