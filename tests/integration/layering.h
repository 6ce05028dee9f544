/// Layering: which room of the tree may include which, and where a library may be named. A checker that reads
/// nothing but #include lines, so that it holds whatever the build links.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace farshade {

struct SourceFile {
  std::string path;                 ///< from the root of the tree, with /
  std::vector<std::string> ours;    ///< #include "..."
  std::vector<std::string> theirs;  ///< #include <...>
};

/// A folder, and the folders it may include; what these see it sees too, and itself.
struct Room {
  std::string_view folder;
  std::vector<std::string_view> sees;
};

/// Includes that begin with `prefix` appear below `folder` only, in at most `files` files.
struct Library {
  std::string_view prefix, folder;
  std::size_t files;
};

struct House {
  std::vector<Room> rooms;
  std::vector<Library> libraries;
  std::string_view guests;  ///< a folder whose files may include anything
};

/// All .h and .cpp files below the rooms' folders.
[[nodiscard]] std::vector<SourceFile> read_tree(const std::filesystem::path& root, const House& house);

/// One sentence for each broken rule; empty where the house stands.
[[nodiscard]] std::vector<std::string> faults(const House& house, const std::vector<SourceFile>& tree);

}  // namespace farshade
