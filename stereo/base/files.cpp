#include "stereo/base/files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <system_error>

#include "stereo/base/descriptor.h"

namespace farshade {
namespace {

namespace fs = std::filesystem;

tl::unexpected<Error> fail_errno(const char* verb, const fs::path& path, int error) {
  const bool missing = error == ENOENT || error == ENOTDIR;
  return fail(
      missing ? Fault::Missing : Fault::Unreadable,
      std::string("cannot ") + verb + " '" + path.string() + "': " + std::generic_category().message(error));
}

/// Reads until `space` is full or the file ends. Returns the number of bytes, or -1 with errno.
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

/// Returns 0, or the errno of the failed write.
int write_fully(int file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t put = ::write(file, bytes.data(), bytes.size());
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return errno;
    bytes = bytes.subspan(static_cast<std::size_t>(put));
  }
  return 0;
}

/// Flags for a new file. A private file must not reuse an existing temporary file, which others may have
/// open.
struct Opening {
  int flags;
  mode_t mode;
  bool durable;  ///< on the disk before it is renamed, so that a power cut leaves the old file or the new one
};
constexpr Opening kPublic{O_TRUNC, 0666, false}, kPrivate{O_EXCL, 0600, true};

Descriptor open_folder(const fs::path& folder) {
  const fs::path named = folder.empty() ? fs::path(".") : folder;
  return Descriptor(::open(named.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
}

/// Brings the name of a new file to the disk. Returns 0 or an errno.
int sync_folder_of(const fs::path& path, Opening how) {
  if (!how.durable) return 0;
  const Descriptor folder = open_folder(path.parent_path());
  return folder.is_open() && ::fsync(folder.number()) == 0 ? 0 : errno;
}

/// Returns 0, or the errno of the failed call.
int create_with(const fs::path& path, std::span<const std::byte> bytes, Opening how) {
  Descriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_NOFOLLOW | O_CLOEXEC | how.flags, how.mode));
  if (!file.is_open()) return errno;
  if (const int error = write_fully(file.number(), bytes)) return error;
  if (how.durable && ::fsync(file.number()) != 0) return errno;
  return file.close_now();
}

/// Refuses a file that others than its owner may read or write, except one that root gives to this user
/// through a group.
Expected<void> only_its_owners(const fs::path& path, const struct stat& status) {
  if (status.st_uid != ::geteuid() && status.st_uid != 0)
    return fail(Fault::Unreadable, "'" + path.string() +
                                       "' holds secrets and belongs to another user: make it anew, or chown "
                                       "it to the one who runs this");
  if (!is_private(status.st_mode, status.st_uid, ::geteuid()))
    return fail(Fault::Unreadable, "'" + path.string() +
                                       "' holds secrets and others than its owner may read or write it: "
                                       "chmod 600 " +
                                       path.string());
  return {};
}

enum class Content { Public, Secret };

Expected<std::vector<std::byte>> read(const fs::path& path, std::uint64_t max_bytes, Content content) {
  // Non-blocking, so that opening a pipe without a writer returns and the pipe can be refused.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  struct stat status {};
  if (!file.is_open() || ::fstat(file.number(), &status) != 0) return fail_errno("read", path, errno);
  if (!S_ISREG(status.st_mode))
    return fail(Fault::Unreadable, "'" + path.string() + "' is not a regular file");
  if (content == Content::Secret)
    if (const auto passed = only_its_owners(path, status); !passed) return tl::unexpected(passed.error());
  const auto size = static_cast<std::uint64_t>(status.st_size);
  if (size > max_bytes)
    return fail(Fault::OutOfRange, "'" + path.string() + "' has " + std::to_string(size) +
                                       " bytes, more than the limit of " + std::to_string(max_bytes));
  std::vector<std::byte> bytes(size);
  const ssize_t got = read_fully(file.number(), bytes);
  if (got < 0) return fail_errno("read", path, errno);
  bytes.resize(static_cast<std::size_t>(got));
  return bytes;
}

/// Writes beside `path`, then renames. Without replacement it makes a hard link, which fails if `path`
/// exists.
Expected<void> write(const fs::path& path, std::span<const std::byte> bytes, Opening how, IfThere if_there) {
  // A thread writes one file at a time, so its id makes the name unique on this machine.
  fs::path partial = path;
  partial += ".partial-" + std::to_string(::gettid());
  int error = create_with(partial, bytes, how);
  if (error == 0 && if_there == IfThere::Replace) {
    if (::rename(partial.c_str(), path.c_str()) != 0) error = errno;
  } else if (error == 0 && ::link(partial.c_str(), path.c_str()) != 0) {
    error = errno;
    if (error == EEXIST) {
      ::unlink(partial.c_str());
      return fail(Fault::Unavailable, "'" + path.string() + "' is there already and stays as it is");
    }
  }
  ::unlink(partial.c_str());
  if (error == 0) error = sync_folder_of(path, how);
  return error == 0 ? Expected<void>{} : fail_errno("write", path, error);
}

}  // namespace

std::int64_t changed_at(const fs::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return 0;
  return std::int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec;
}

Expected<std::vector<std::byte>> read_file(const fs::path& path, std::uint64_t max_bytes) {
  return read(path, max_bytes, Content::Public);
}

bool is_private(unsigned mode, unsigned owner, unsigned reader) {
  constexpr unsigned kOthersReadOrWrite = S_IRGRP | S_IWGRP | S_IROTH | S_IWOTH;
  const unsigned of_others = mode & kOthersReadOrWrite;
  return of_others == 0 || (of_others == S_IRGRP && owner == 0 && reader != 0);
}

Expected<std::vector<std::byte>> read_private_file(const fs::path& path, std::uint64_t max_bytes) {
  return read(path, max_bytes, Content::Secret);
}

Expected<void> write_file_atomically(const fs::path& path, std::span<const std::byte> bytes) {
  return write(path, bytes, kPublic, IfThere::Replace);
}

Expected<void> write_private_file(const fs::path& path, std::string_view text, IfThere if_there) {
  return write(path, std::as_bytes(std::span(text)), kPrivate, if_there);
}

Expected<void> write_file_atomically(const fs::path& path, std::string_view text) {
  return write_file_atomically(path, std::as_bytes(std::span(text)));
}

Expected<void> make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail(Fault::Unreadable, "cannot make " + folder.string() + ": " + error.message());
  std::string probe = (folder / ".probe-XXXXXX").string();
  const Descriptor file(::mkostemp(probe.data(), O_CLOEXEC));
  if (!file.is_open()) return fail_errno("write to", folder, errno);
  ::unlink(probe.c_str());
  return {};
}

Expected<FolderLock> FolderLock::of(const fs::path& folder) {
  Descriptor opened = open_folder(folder);
  while (opened.is_open() && ::flock(opened.number(), LOCK_EX) != 0)
    if (errno != EINTR) return fail_errno("lock", folder, errno);
  if (!opened.is_open()) return fail_errno("lock", folder, errno);
  return FolderLock(std::move(opened));
}

}  // namespace farshade
