#include "rt_server/fetch/served_files.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <system_error>

namespace farshade {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFewFiles = 500;  ///< fit in the 1,024 descriptors that most systems allow at first

/// Reads all of `into` at `begin`; false if the file ends before or cannot be read.
bool read_at(int file, std::uint64_t begin, std::span<std::byte> into) {
  while (!into.empty()) {
    const ssize_t got = ::pread(file, into.data(), into.size(), static_cast<off_t>(begin));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    begin += static_cast<std::uint64_t>(got);
    into = into.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

/// Each served file stays open: allows as many as the system lets this process have.
void allow_open_files() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &limit);
}

std::int64_t nanoseconds_of(const timespec& time) {
  return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

bool is_as_loaded(const struct stat& status, const SceneFile& file) {
  return S_ISREG(status.st_mode) && static_cast<std::uint64_t>(status.st_size) == file.bytes &&
         nanoseconds_of(status.st_mtim) == file.changed_ns;
}

tl::unexpected<Error> has_changed(const std::string& name) {
  return fail(Fault::Mismatch,
              "'" + name + "' has changed: restart the server, so that all clients see the same scene");
}

}  // namespace

Expected<ServedFiles> ServedFiles::open(const fs::path& folder, const std::vector<SceneFile>& loaded) {
  ServedFiles served;
  if (loaded.size() > kFewFiles) allow_open_files();
  for (const SceneFile& file : loaded) {
    Descriptor opened(::open((folder / file.name).c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
    struct stat status {};
    if (!opened.is_open() || ::fstat(opened.number(), &status) != 0)
      return fail(Fault::Unreadable, "'" + file.name + "' of the scene cannot be read: " +
                                         std::generic_category().message(errno));
    if (!is_as_loaded(status, file)) return has_changed(file.name);
    served.files_.push_back({file.name, file.bytes, file.digest});
    served.opened_.push_back({std::move(opened), file.changed_ns});
  }
  if (Expected<void> fine = check_offered(served.files_); !fine) return tl::unexpected(fine.error());
  return served;
}

Expected<void> ServedFiles::read(std::uint64_t begin, std::span<std::byte> into) const {
  for (std::size_t i = 0; i < files_.size() && !into.empty(); ++i) {
    if (begin >= files_[i].bytes) {
      begin -= files_[i].bytes;
      continue;
    }
    const auto here = std::min<std::uint64_t>(into.size(), files_[i].bytes - begin);
    struct stat status {};
    const int file = opened_[i].file.number();
    if (::fstat(file, &status) != 0 || nanoseconds_of(status.st_mtim) != opened_[i].changed_ns ||
        !read_at(file, begin, into.first(here)))
      return has_changed(files_[i].name);
    into = into.subspan(here);
    begin = 0;
  }
  return {};
}

}  // namespace farshade
