/// SceneCache: the files of one offer on the client's disk. A file that is whole and has its hash lies in the
/// scene's folder; what has come of another one lies beside it, by its number, so that the names of the
/// server do not matter there. Nothing is written outside of the folder, also through links.
///
///   FOLDER/KEY/NAME        whole files
///   FOLDER/KEY.part/NUMBER  what has come of a file
///   FOLDER/KEY.lock         locked by the process that fetches
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "stereo/base/descriptor.h"
#include "stereo/fetch/scene_offer.h"

namespace farshade {

/// A part of the content: all files, one after the other.
struct ContentRange {
  std::uint64_t begin = 0, end = 0;
  friend bool operator==(const ContentRange&, const ContentRange&) = default;
};

class SceneCache {
 public:
  /// Locks the scene's place in `folder`, and hashes what is there: about a second for each GB. While another
  /// process has the lock, it calls `waits` a few times a second and gives up (Unavailable) when that is
  /// false.
  [[nodiscard]] static Expected<SceneCache> open(const std::filesystem::path& folder,
                                                 std::vector<OfferedFile> files,
                                                 const std::function<bool()>& waits);

  /// The first range that is missing; nothing if the scene is whole.
  [[nodiscard]] std::optional<ContentRange> missing() const;
  [[nodiscard]] std::uint64_t missing_bytes() const;

  /// Appends the next bytes of missing(). A file that becomes whole is checked, flushed to the disk and
  /// renamed. If its hash is wrong: a file that was there in part is missing again; a file that came as a
  /// whole is an error (Mismatch). If the disk is full (Unreadable), what came before is kept.
  [[nodiscard]] Expected<void> append(std::span<const std::byte> bytes);

  /// The scene's own file.
  [[nodiscard]] std::filesystem::path scene() const { return folder_ / files_.front().name; }

 private:
  struct State {
    std::uint64_t bytes = 0;  ///< that are there
    bool is_whole = false;
    bool was_resumed = false;  ///< some of its bytes are from an earlier process
  };

  SceneCache(const std::filesystem::path& folder, std::vector<OfferedFile> files);
  [[nodiscard]] Expected<void> look();
  [[nodiscard]] Expected<void> append_to(std::size_t file, std::span<const std::byte> bytes);
  [[nodiscard]] Expected<void> complete(std::size_t file);
  [[nodiscard]] std::filesystem::path part(std::size_t file) const { return parts_ / std::to_string(file); }
  [[nodiscard]] Expected<void> write_failed(int error) const;

  std::filesystem::path folder_, parts_;
  std::vector<OfferedFile> files_;
  std::vector<State> states_;
  Descriptor lock_, writing_;  ///< the part of the first file that is missing
};

}  // namespace farshade
