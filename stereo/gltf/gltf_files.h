/// The bytes of a scene before they are parsed: files and data URIs within byte limits, the GLB container,
/// and the nesting depth of the JSON text.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stereo/base/expected.h"
#include "stereo/gltf/gltf.h"
#include "stereo/gltf/gltf_repairs.h"

namespace farshade::gltf {

/// "data:...", in capitals or not.
[[nodiscard]] bool is_data_uri(std::string_view uri);

/// Reads what the URIs of a scene name: data URIs, and files in the folder of the scene. The files together
/// may not have more bytes than the budget.
class SceneFolder {
 public:
  /// With an empty `folder`, no file can be read.
  SceneFolder(std::filesystem::path folder, std::uint64_t budget_bytes, ListFiles list = ListFiles::No)
      : folder_(std::move(folder)), left_bytes_(budget_bytes), list_(list) {}

  /// The bytes of a base64 data URI, or of the file that a relative URI (RFC 3986, with percent escapes)
  /// names. Refuses absolute paths, other schemes, `..`, links that lead out of the folder, and empty files.
  [[nodiscard]] Expected<std::vector<std::uint8_t>> load(const std::string& uri);

  /// The files that were read, with names in normal form, sorted, each once. Empty without ListFiles::Yes.
  [[nodiscard]] std::vector<SceneFile> files() const;

 private:
  [[nodiscard]] Expected<std::vector<std::byte>> read(const std::string& path);

  std::filesystem::path folder_;
  std::uint64_t left_bytes_;
  ListFiles list_;
  std::map<std::string, SceneFile> files_;
};

/// The parts of a glTF file, as views into its bytes.
struct Container {
  std::string_view json;
  std::span<const std::byte> bin{};  ///< the binary chunk of a GLB; empty if there is none
  Repairs repairs{};                 ///< faults of the container
};
[[nodiscard]] Expected<Container> open_container(std::span<const std::byte> file);

/// Refuses JSON that is nested deeper than `most`. It counts brackets outside of strings and does not
/// recurse, so that the recursion of the JSON library is bounded.
[[nodiscard]] Expected<void> check_json_depth(std::string_view json, std::uint32_t most);

}  // namespace farshade::gltf
