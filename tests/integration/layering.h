/// Layering: which folder may include which, and where a third-party library may be named. The checks read
/// #include lines and CMakeLists.txt files only, so they do not depend on what the build links by accident.
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

/// A folder and the folders that it may include. Permission is transitive: a folder may also include what
/// those folders may include. It may always include itself.
struct Layer {
  std::string_view folder;
  std::vector<std::string_view> sees;
};

/// Only files below `folder` may include headers that begin with `prefix`, and at most `files` of them.
struct Library {
  std::string_view prefix, folder;
  std::size_t files;
};

struct Layering {
  std::vector<Layer> layers;
  std::vector<Library> libraries;
  std::string_view unrestricted;  ///< a folder whose files may include anything
};

/// All .h and .cpp files below the layers' folders.
[[nodiscard]] std::vector<SourceFile> read_tree(const std::filesystem::path& root, const Layering& layering);

/// One sentence for each broken rule; empty if the tree keeps all of them.
[[nodiscard]] std::vector<std::string> faults(const Layering& layering, const std::vector<SourceFile>& tree);

}  // namespace farshade
