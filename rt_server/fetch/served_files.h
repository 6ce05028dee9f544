/// ServedFiles: the files of the scene as one content, read from disk when a client needs them.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "stereo/base/descriptor.h"
#include "stereo/fetch/scene_offer.h"
#include "stereo/scene/scene.h"

namespace farshade {

class ServedFiles {
 public:
  /// Opens the files of a scene (Scene::files) in its folder. Mismatch if one has changed since it was
  /// loaded, Unreadable if it cannot be read, otherwise fails as check_offered. Reads nothing: the hashes are
  /// those of the bytes that were loaded.
  [[nodiscard]] static Expected<ServedFiles> open(const std::filesystem::path& folder,
                                                  const std::vector<SceneFile>& loaded);

  [[nodiscard]] const std::vector<OfferedFile>& files() const { return files_; }

  /// Reads content from `begin` on; `into` lies inside the content. Mismatch if a file is no longer what it
  /// was when it was opened. Any thread may call it.
  [[nodiscard]] Expected<void> read(std::uint64_t begin, std::span<std::byte> into) const;

 private:
  struct Opened {
    Descriptor file;
    std::int64_t changed_ns = 0;
  };
  std::vector<OfferedFile> files_;
  std::vector<Opened> opened_;
};

}  // namespace farshade
