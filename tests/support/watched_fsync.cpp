#include "tests/support/watched_fsync.h"

#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <string>

namespace farshade {
namespace {

thread_local WatchedFsync* watching_fsync = nullptr;

}  // namespace

WatchedFsync::WatchedFsync() {
  watching_fsync = this;
}

WatchedFsync::~WatchedFsync() {
  watching_fsync = nullptr;
}

extern "C" int fsync(const int file) {
  if (watching_fsync != nullptr) {
    watching_fsync->synced.push_back(std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(file)));
    errno = watching_fsync->fails_with;
    if (errno != 0) return -1;
  }
  return static_cast<int>(::syscall(SYS_fsync, file));
}

}  // namespace farshade
