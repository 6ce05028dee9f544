/// Level cache: keeps the levels of a scene in a file, so that they are made once. A file that is broken,
/// from another version or of another scene is ignored and replaced.
#pragma once

#include <filesystem>
#include <span>

#include "stereo/base/expected.h"
#include "stereo/lod/levels.h"

namespace farshade {

/// The file of a scene in `folder`.
[[nodiscard]] std::filesystem::path level_file(const std::filesystem::path& folder, const SceneHash& scene);

/// The levels of `scene` as a file's bytes.
[[nodiscard]] std::vector<std::byte> encode_levels(const Scene& scene, const SceneLevels& levels);

/// Refuses (Malformed) bytes that are no levels of `scene`: every index and range is checked.
[[nodiscard]] Expected<SceneLevels> decode_levels(const Scene& scene, std::span<const std::byte> bytes);

/// The levels of a scene, and how they were obtained.
struct CachedLevels {
  SceneLevels levels;
  bool from_file = false;
  std::string trouble{};  ///< why the file was not read or written; empty if all went well
};

/// Reads the levels from `folder`; if there are none, makes them and writes them there. Never fails: without
/// a usable folder the levels are made every time.
[[nodiscard]] CachedLevels cached_levels(const Scene& scene, const std::filesystem::path& folder);

}  // namespace farshade
