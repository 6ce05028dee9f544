/// ServedFiles: the files of the scene as one content, read from disk when a client needs them.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "stereo/base/descriptor.h"
#include "stereo/fetch/scene_offer.h"

namespace farshade {

class ServedFiles {
 public:
  /// Opens and hashes the scene file and the files that it names (Scene::files). Fails as check_offered, or
  /// if a file cannot be read. `stopped` is polled.
  [[nodiscard]] static Expected<ServedFiles> open(const std::filesystem::path& scene,
                                                  const std::vector<std::string>& names,
                                                  const std::function<bool()>& stopped);

  [[nodiscard]] const std::vector<OfferedFile>& files() const { return files_; }

  /// Reads content from `begin` on; `into` lies inside the content. Mismatch if a file is no longer what it
  /// was when it was opened. Any thread may call it.
  [[nodiscard]] Expected<void> read(std::uint64_t begin, std::span<std::byte> into) const;

 private:
  struct Opened {
    Descriptor file;
    timespec changed{};
  };
  std::vector<OfferedFile> files_;
  std::vector<Opened> opened_;
};

}  // namespace farshade
