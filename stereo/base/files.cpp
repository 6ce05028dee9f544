#include "stereo/base/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace farshade {
namespace {

namespace fs = std::filesystem;

/// An open file, closed at the end.
struct Descriptor {
  int number = -1;
  explicit Descriptor(int opened) : number(opened) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { close_now(); }
  /// 0, or the errno of the late write errors that only close() tells.
  int close_now() {
    const int closed = number;
    number = -1;
    return closed < 0 || ::close(closed) == 0 ? 0 : errno;
  }
};

tl::unexpected<Error> fail_errno(const char* verb, const fs::path& path, int error) {
  const bool missing = error == ENOENT || error == ENOTDIR;
  return fail(
      missing ? Fault::Missing : Fault::Unreadable,
      std::string("cannot ") + verb + " '" + path.string() + "': " + std::generic_category().message(error));
}

/// Bytes read until `space` is full or the file ends; -1 and errno on failure.
ssize_t read_fully(int file, std::span<std::byte> space) {
  std::size_t done = 0;
  while (done < space.size()) {
    const ssize_t got = ::read(file, space.data() + done, space.size() - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return -1;
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  return static_cast<ssize_t>(done);
}

/// 0, or the errno of the write that failed.
int write_fully(int file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t put = ::write(file, bytes.data(), bytes.size());
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return errno;
    bytes = bytes.subspan(static_cast<std::size_t>(put));
  }
  return 0;
}

/// 0, or the errno of what failed.
int create_with(const fs::path& path, std::span<const std::byte> bytes) {
  Descriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0666));
  if (file.number < 0) return errno;
  if (const int error = write_fully(file.number, bytes)) return error;
  return file.close_now();
}

}  // namespace

Expected<std::vector<std::byte>> read_file(const fs::path& path, std::uint64_t max_bytes) {
  // Non-blocking, so that opening a pipe that nobody writes returns and can be refused.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  struct stat status {};
  if (file.number < 0 || ::fstat(file.number, &status) != 0) return fail_errno("read", path, errno);
  if (!S_ISREG(status.st_mode))
    return fail(Fault::Unreadable, "'" + path.string() + "' is not a regular file");
  const auto size = static_cast<std::uint64_t>(status.st_size);
  if (size > max_bytes)
    return fail(Fault::OutOfRange, "'" + path.string() + "' has " + std::to_string(size) +
                                       " bytes, more than the limit of " + std::to_string(max_bytes));
  std::vector<std::byte> bytes(size);
  const ssize_t got = read_fully(file.number, bytes);
  if (got < 0) return fail_errno("read", path, errno);
  bytes.resize(static_cast<std::size_t>(got));
  return bytes;
}

Expected<void> write_file_atomically(const fs::path& path, std::span<const std::byte> bytes) {
  // A thread writes one file at a time, so its number makes the name unique on this machine.
  fs::path partial = path;
  partial += ".partial-" + std::to_string(::gettid());
  int error = create_with(partial, bytes);
  if (error == 0 && ::rename(partial.c_str(), path.c_str()) != 0) error = errno;
  if (error == 0) return {};
  ::unlink(partial.c_str());
  return fail_errno("write", path, error);
}

Expected<void> write_file_atomically(const fs::path& path, std::string_view text) {
  return write_file_atomically(path, std::as_bytes(std::span(text)));
}

}  // namespace farshade
