/// ChildProgram: runs a program as a child process and reads its output.
#pragma once

#include <sys/types.h>

#include <csignal>
#include <optional>
#include <string>
#include <vector>

#include "stereo/base/check.h"

namespace farshade {

class ChildProgram {
 public:
  /// Starts `arguments[0]`, a path or a name in PATH, with the rest as its arguments.
  explicit ChildProgram(const std::vector<std::string>& arguments);
  ChildProgram(const ChildProgram&) = delete;
  ChildProgram& operator=(const ChildProgram&) = delete;
  /// Kills the program if it still runs.
  ~ChildProgram();

  /// Waits for the next line of standard output that begins with `prefix`, and returns the rest of that line.
  /// Returns nothing if the output ends first.
  std::optional<std::string> line_after(const std::string& prefix) { return output_.line_after(prefix); }
  /// The same for standard error.
  std::optional<std::string> error_line_after(const std::string& prefix) {
    return errors_.line_after(prefix);
  }

  /// Waits for the next line of standard error that contains `words`, and returns it. Returns nothing if the
  /// output ends first.
  std::optional<std::string> error_line_with(const std::string& words);

  /// Not after wait(): then the signal would go to every process.
  void send(int signal) const {
    check(pid_ > 0, "a program gets signals until it is waited for");
    kill(pid_, signal);
  }

  /// From now on nobody reads what it writes: its pipes are as small as pipes can be.
  void stop_reading() const;
  /// From now on whatever it writes fails. No output can be asked for any more.
  void close_pipes();

  /// Stops the program and waits until it stands still. SIGCONT lets it go on.
  void stop() const;

  /// Valid until wait().
  [[nodiscard]] pid_t id() const { return pid_; }

  /// Waits until the program ends. Returns the exit status, or minus the signal that ended it.
  int wait();

  /// Waits until the program ends. Returns everything it wrote to standard error.
  [[nodiscard]] std::string errors() { return errors_.all(); }
  /// The same for standard output.
  [[nodiscard]] std::string output() { return output_.all(); }

 private:
  /// The read end of a pipe, and the text read from it.
  struct Stream {
    int end = -1;
    std::string text{};
    std::size_t lines_taken = 0;  ///< bytes of `text` up to the last line that line_after returned

    std::optional<std::string> line_after(const std::string& prefix);
    const std::string& all();
  };

  pid_t pid_ = -1;
  Stream output_, errors_;
};

}  // namespace farshade
