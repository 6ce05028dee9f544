#include "rt_server/fetch/served_files.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <system_error>

namespace farshade {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kHashed_bytes = std::size_t{1} << 20;
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

Expected<Digest> hash_file(const Descriptor& file, const OfferedFile& offered,
                           const std::function<bool()>& stopped) {
  Digester digester;
  std::vector<std::byte> piece;
  for (std::uint64_t done = 0; done < offered.bytes; done += piece.size()) {
    piece.resize(std::min<std::uint64_t>(kHashed_bytes, offered.bytes - done));
    if (stopped()) return fail(Fault::Unavailable, "stopped");
    if (!read_at(file.number(), done, piece))
      return fail(Fault::Unreadable, "'" + offered.name + "' of the scene cannot be read");
    digester.add(piece);
  }
  return digester.finish();
}

}  // namespace

Expected<ServedFiles> ServedFiles::open(const fs::path& scene, const std::vector<std::string>& names,
                                        const std::function<bool()>& stopped) {
  ServedFiles served;
  if (names.size() > kFewFiles) allow_open_files();
  std::vector<std::string> all{scene.filename().string()};
  std::ranges::copy_if(names, std::back_inserter(all), [&](const auto& name) { return name != all.front(); });
  for (const std::string& name : all) {
    Opened opened{
        Descriptor(::open((scene.parent_path() / name).c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC))};
    struct stat status {};
    if (!opened.file.is_open() || ::fstat(opened.file.number(), &status) != 0)
      return fail(Fault::Unreadable,
                  "'" + name + "' of the scene cannot be read: " + std::generic_category().message(errno));
    opened.changed = status.st_mtim;
    served.files_.push_back({name, static_cast<std::uint64_t>(status.st_size), {}});
    served.opened_.push_back(std::move(opened));
  }
  if (Expected<void> fine = check_offered(served.files_); !fine) return tl::unexpected(fine.error());
  for (std::size_t i = 0; i < served.files_.size(); ++i) {
    const Expected<Digest> hash = hash_file(served.opened_[i].file, served.files_[i], stopped);
    if (!hash) return tl::unexpected(hash.error());
    served.files_[i].hash = *hash;
  }
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
    const timespec changed = opened_[i].changed;
    if (::fstat(file, &status) != 0 || status.st_mtim.tv_sec != changed.tv_sec ||
        status.st_mtim.tv_nsec != changed.tv_nsec || !read_at(file, begin, into.first(here)))
      return fail(
          Fault::Mismatch,
          "'" + files_[i].name + "' has changed: restart the server, so that all clients see the same scene");
    into = into.subspan(here);
    begin = 0;
  }
  return {};
}

}  // namespace farshade
