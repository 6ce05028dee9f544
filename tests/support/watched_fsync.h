/// WatchedFsync: records the calls of fsync. The test program defines fsync itself.
#pragma once

#include <filesystem>
#include <vector>

namespace farshade {

/// Records the calls of this thread while it lives. One of them at a time.
class WatchedFsync {
 public:
  WatchedFsync();
  WatchedFsync(const WatchedFsync&) = delete;
  WatchedFsync& operator=(const WatchedFsync&) = delete;
  ~WatchedFsync();

  std::vector<std::filesystem::path> synced;  ///< the names that the files had then, in order
  int fails_with = 0;                         ///< unless 0: calls fail with this errno
};

}  // namespace farshade
