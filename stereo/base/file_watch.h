/// FileWatch tells when a file has changed: once per change, when it has not changed further between two
/// looks. So a file that an editor is writing is not read by halves.
#pragma once

#include <filesystem>
#include <utility>

#include "stereo/base/files.h"

namespace farshade {

class FileWatch {
 public:
  explicit FileWatch(std::filesystem::path path) : path_(std::move(path)), seen_(changed_at(path_)) {}

  [[nodiscard]] bool has_changed() {
    const std::int64_t now = changed_at(path_);
    const bool settled = now != seen_ && now == last_;
    last_ = now;
    if (settled) seen_ = now;
    return settled;
  }
  void mark_as_seen() { seen_ = changed_at(path_); }

 private:
  std::filesystem::path path_;
  std::int64_t seen_, last_ = 0;
};

}  // namespace farshade
