#include "tests/integration/child_program.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <utility>

namespace farshade {
namespace {

std::pair<int, int> make_pipe() {
  std::array<int, 2> ends{};
  check_eq(pipe2(ends.data(), O_CLOEXEC), 0, "the system has a pipe");
  return {ends[0], ends[1]};
}

/// Waits for output and appends it to `text`. Returns false at the end.
bool read_more(int from, std::string& text) {
  std::array<char, 4096> buffer;
  const ssize_t size = read(from, buffer.data(), buffer.size());
  if (size > 0) text.append(buffer.data(), static_cast<std::size_t>(size));
  return size > 0;
}

}  // namespace

ChildProgram::ChildProgram(const std::vector<std::string>& arguments) {
  const auto [output, output_end] = make_pipe();
  const auto [errors, errors_end] = make_pipe();
  output_.end = output;
  errors_.end = errors;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, output_end, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, errors_end, STDERR_FILENO);
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  check_eq(posix_spawnp(&pid_, argv[0], &actions, nullptr, argv.data(), environ), 0, "the program starts");
  posix_spawn_file_actions_destroy(&actions);
  close(output_end);
  close(errors_end);
}

ChildProgram::~ChildProgram() {
  if (pid_ > 0) {
    send(SIGKILL);
    wait();
  }
  for (const int end : {output_.end, errors_.end})
    if (end >= 0) close(end);
}

std::optional<std::string> ChildProgram::error_line_with(const std::string& words) {
  while (auto line = error_line_after(""))
    if (line->find(words) != line->npos) return line;
  return std::nullopt;
}

void ChildProgram::stop_reading() const {
  for (const int end : {output_.end, errors_.end})
    check(fcntl(end, F_SETPIPE_SZ, 1) > 0, "a pipe that is almost empty can be made smaller");
}

void ChildProgram::close_pipes() {
  for (Stream* stream : {&output_, &errors_}) close(std::exchange(stream->end, -1));
}

void ChildProgram::stop() const {
  send(SIGSTOP);
  siginfo_t stopped{};
  check_eq(waitid(P_PID, static_cast<id_t>(pid_), &stopped, WSTOPPED), 0,
           "the program runs until it is stopped");
}

std::optional<std::string> ChildProgram::Stream::line_after(const std::string& prefix) {
  while (true) {
    std::size_t newline;
    while ((newline = text.find('\n', lines_taken)) == std::string::npos)
      if (!read_more(end, text)) return std::nullopt;
    const std::string line = text.substr(lines_taken, newline - lines_taken);
    lines_taken = newline + 1;
    if (line.starts_with(prefix)) return line.substr(prefix.size());
  }
}

const std::string& ChildProgram::Stream::all() {
  while (read_more(end, text)) {
  }
  return text;
}

int ChildProgram::wait() {
  int status = 0;
  check_eq(waitpid(std::exchange(pid_, -1), &status, 0) > 0, true, "the child is waited for once");
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

}  // namespace farshade
