/// A program of ours as a child process: what it says line by line, its end, and all it said until then.
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
  std::optional<std::string> line_after(const std::string& prefix) { return output_.line_after(prefix); }
  /// The same of standard error.
  std::optional<std::string> error_line_after(const std::string& prefix) {
    return errors_.line_after(prefix);
  }

  void send(int signal) const { kill(pid_, signal); }

  /// While it has not been waited for.
  [[nodiscard]] pid_t id() const { return pid_; }

  /// Waits for its end: the exit status, or minus the signal that ended it.
  int wait();

  /// All that it wrote to standard error; waits for its end.
  [[nodiscard]] std::string errors() { return errors_.all(); }

 private:
  /// The read end of a pipe, and what came through it.
  struct Stream {
    int end = -1;
    std::string text{};
    std::size_t lines_taken = 0;  ///< bytes of `text` that line_after has passed

    std::optional<std::string> line_after(const std::string& prefix);
    const std::string& all();
  };

  pid_t pid_ = -1;
  Stream output_, errors_;
};

}  // namespace farshade
