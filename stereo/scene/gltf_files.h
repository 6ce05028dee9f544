/// Bytes before anything is parsed: files under byte limits, the scene's folder as the only place that it may
/// name, the GLB container, and the depth of its JSON text.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stereo/base/expected.h"

namespace farshade::gltf {

/// The scene's folder: hands out the files inside of it until a budget of bytes is spent.
class SceneFolder {
 public:
  /// An empty `folder` hands out nothing.
  SceneFolder(std::filesystem::path folder, std::uint64_t budget_bytes)
      : folder_(std::move(folder)), left_bytes_(budget_bytes) {}

  /// The file that a decoded relative URI names. Refuses absolute paths, schemes, `..` and links that lead
  /// outside.
  [[nodiscard]] Expected<std::vector<std::byte>> read(const std::string& uri);

 private:
  std::filesystem::path folder_;
  std::uint64_t left_bytes_;
};

/// A glTF file, taken apart. Views into the file.
struct Container {
  std::string_view json;
  bool is_binary = false;          ///< GLB
  std::span<const std::byte> bin;  ///< the GLB's binary chunk, empty where it has none
};
[[nodiscard]] Expected<Container> open_container(std::span<const std::byte> file);

/// Refuses JSON nested deeper than `most`, by counting brackets outside of strings. Parsers recurse; this
/// does not.
[[nodiscard]] Expected<void> check_json_depth(std::string_view json, std::uint32_t most);

}  // namespace farshade::gltf
