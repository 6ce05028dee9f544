#include "vr_client/fetch/scene_cache.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <algorithm>
#include <system_error>
#include <thread>

#include "stereo/base/cache_file.h"

namespace farshade {
namespace {

namespace fs = std::filesystem;

constexpr Duration kLockPoll = std::chrono::milliseconds(100);
constexpr std::size_t kPiece_bytes = std::size_t{1} << 20;
constexpr int kOnlyFiles = O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK;

tl::unexpected<Error> cannot(const char* verb, const fs::path& path, int error) {
  return fail(Fault::Unreadable,
              fmt::format("cannot {} '{}': {}", verb, path.string(), std::generic_category().message(error)));
}

/// Makes a folder, unless it is there: another client may make it at the same time. Refuses a link in its
/// place.
Expected<void> make_folder_itself(const fs::path& folder) {
  std::error_code error, unknown;
  fs::create_directory(folder, error);
  const fs::file_type type = fs::symlink_status(folder, unknown).type();
  if (type == fs::file_type::directory) return {};
  if (type == fs::file_type::not_found) return cannot("make the folder", folder, error.value());
  return fail(Fault::Unreadable, "'" + folder.string() + "' is no folder: delete it");
}

/// Makes the folder of the file `name` below `folder`. Refuses links in place of folders.
Expected<void> make_folders_below(const fs::path& folder, const fs::path& name) {
  fs::path made = folder;
  for (const fs::path& step : name.parent_path()) {
    made /= step;
    if (Expected<void> there = make_folder_itself(made); !there) return there;
  }
  return {};
}

/// The size of the regular file, no link, at `path`; 0 if there is none.
std::uint64_t size_there(const fs::path& path) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) == 0 && S_ISREG(status.st_mode)
             ? static_cast<std::uint64_t>(status.st_size)
             : 0;
}

/// Whether the file at `path` is the offered one.
bool is_offered(const fs::path& path, const OfferedFile& offered) {
  if (size_there(path) != offered.bytes) return false;
  const Descriptor file(::open(path.c_str(), O_RDONLY | kOnlyFiles));
  Digester digester;
  std::vector<std::byte> piece(kPiece_bytes);
  ssize_t got = 0;
  while (file.is_open() && (got = ::read(file.number(), piece.data(), piece.size())) > 0)
    digester.add(std::span(piece).first(static_cast<std::size_t>(got)));
  return file.is_open() && got == 0 && digester.finish() == offered.hash;
}

Expected<Descriptor> lock_file(const fs::path& path, const std::function<bool()>& waits) {
  Descriptor lock(::open(path.c_str(), O_RDWR | O_CREAT | kOnlyFiles, 0600));
  if (!lock.is_open()) return cannot("open", path, errno);
  while (::flock(lock.number(), LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK && errno != EINTR) return cannot("lock", path, errno);
    if (!waits()) return fail(Fault::Unavailable, "another client is fetching the same scene");
    std::this_thread::sleep_for(kLockPoll);
  }
  return lock;
}

}  // namespace

SceneCache::SceneCache(const fs::path& folder, std::vector<OfferedFile> files)
    : files_(std::move(files)), states_(files_.size()) {
  folder_ = folder / cache_name(digest_of(files_));
  parts_ = folder_;
  parts_ += ".part";
}

Expected<SceneCache> SceneCache::open(const fs::path& folder, std::vector<OfferedFile> files,
                                      const std::function<bool()>& waits) {
  SceneCache cache(folder, std::move(files));
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return cannot("make the folder", folder, error.value());
  for (const fs::path& own : {cache.folder_, cache.parts_})
    if (Expected<void> made = make_folder_itself(own); !made) return tl::unexpected(made.error());
  fs::path lock = cache.folder_;
  lock += ".lock";
  Expected<Descriptor> locked = lock_file(lock, waits);
  if (!locked) return tl::unexpected(locked.error());
  cache.lock_ = std::move(*locked);
  if (Expected<void> seen = cache.look(); !seen) return tl::unexpected(seen.error());
  std::error_code unknown;
  const fs::space_info disk = fs::space(folder, unknown);
  if (!unknown && disk.available < cache.missing_bytes())
    return tl::unexpected(cache.write_failed(ENOSPC).error());
  return cache;
}

Expected<void> SceneCache::look() {
  for (std::size_t i = 0; i < files_.size(); ++i) {
    State& state = states_[i];
    if (Expected<void> made = make_folders_below(folder_, files_[i].name); !made) return made;
    state.is_whole = is_offered(folder_ / files_[i].name, files_[i]);
    state.bytes = state.is_whole ? files_[i].bytes : size_there(part(i));
    state.was_resumed = state.bytes > 0;
    if (state.is_whole || state.bytes < files_[i].bytes) continue;
    // A process ended between the last byte and the check, or the part is of no use.
    if (Expected<void> done = complete(i); !done) return done;
  }
  return {};
}

std::optional<ContentRange> SceneCache::missing() const {
  std::uint64_t begin = 0;
  std::optional<ContentRange> range;
  for (std::size_t i = 0; i < files_.size(); ++i) {
    const bool goes_on = range && states_[i].bytes == 0;
    if (range && !goes_on) break;
    if (!range && states_[i].bytes < files_[i].bytes)
      range.emplace(ContentRange{begin + states_[i].bytes, 0});
    begin += files_[i].bytes;
    if (range) range->end = begin;
  }
  return range;
}

std::uint64_t SceneCache::missing_bytes() const {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < files_.size(); ++i) sum += files_[i].bytes - states_[i].bytes;
  return sum;
}

Expected<void> SceneCache::append(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    std::size_t file = 0;
    while (file < files_.size() && states_[file].bytes == files_[file].bytes) ++file;
    if (file == files_.size()) return fail(Fault::Malformed, "more bytes than the scene has");
    const auto here = std::min<std::uint64_t>(bytes.size(), files_[file].bytes - states_[file].bytes);
    if (Expected<void> written = append_to(file, bytes.first(here)); !written) return written;
    bytes = bytes.subspan(here);
    if (states_[file].bytes < files_[file].bytes) continue;
    if (Expected<void> done = complete(file); !done) return done;
    if (states_[file].bytes == 0)
      return {};  // this file is missing again, so what follows is not its content
  }
  return {};
}

Expected<void> SceneCache::write_failed(int error) const {
  if (error != ENOSPC && error != EDQUOT && error != EFBIG) return cannot("write to", parts_, error);
  return fail(
      Fault::Unreadable,
      fmt::format("the disk of {} is full: the scene needs {:.1f} MB more there; what has come is kept. "
                  "Make room, or choose another disk with XDG_CACHE_HOME",
                  folder_.parent_path().string(), static_cast<double>(missing_bytes()) * 1e-6));
}

Expected<void> SceneCache::append_to(std::size_t file, std::span<const std::byte> bytes) {
  State& state = states_[file];
  if (!writing_.is_open()) {
    if (state.bytes == 0) fs::remove(part(file));  // also a link
    writing_ = Descriptor(::open(part(file).c_str(), O_WRONLY | O_CREAT | O_APPEND | kOnlyFiles, 0600));
    if (!writing_.is_open()) return write_failed(errno);
  }
  while (!bytes.empty()) {
    const ssize_t put = ::write(writing_.number(), bytes.data(), bytes.size());
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return write_failed(errno);
    state.bytes += static_cast<std::uint64_t>(put);
    bytes = bytes.subspan(static_cast<std::size_t>(put));
  }
  return {};
}

Expected<void> SceneCache::complete(std::size_t file) {
  State& state = states_[file];
  int error = 0;
  if (writing_.is_open() && ::fsync(writing_.number()) != 0) error = errno;
  if (const int late = writing_.close_now(); error == 0) error = late;
  if (error != 0) return write_failed(error);
  if (is_offered(part(file), files_[file])) {
    state.is_whole = true;
    const fs::path whole = folder_ / files_[file].name;
    if (::rename(part(file).c_str(), whole.c_str()) != 0) return cannot("rename to", whole, errno);
    return {};
  }
  fs::remove(part(file));
  const bool was_resumed = state.was_resumed;
  state = {};
  if (was_resumed) return {};
  return fail(Fault::Mismatch,
              fmt::format("'{}' does not have the hash that the server promised: has it changed "
                          "on the server? Restart the server",
                          files_[file].name));
}

}  // namespace farshade
