/// Declared libraries: compares the libraries that each CMakeLists.txt declares with the headers that the
/// library's files include.
#pragma once

#include "tests/integration/layering.h"

namespace farshade {

/// One `farshade_library` block, or one `add_executable` with its `target_link_libraries`.
struct DeclaredLibrary {
  std::string name, folder;                  ///< the folder from the root of the tree, with /
  std::vector<std::string> files;            ///< from the root of the tree
  std::vector<std::string> depends;          ///< visible to whoever links the library
  std::vector<std::string> private_depends;  ///< for the library's own .cpp files
};

/// The blocks of one CMakeLists.txt. `folder` is where it lies, from the root of the tree.
[[nodiscard]] std::vector<DeclaredLibrary> parse_libraries(const std::string& cmake,
                                                           const std::string& folder);

/// The blocks of all CMakeLists.txt files below `tops`.
[[nodiscard]] std::vector<DeclaredLibrary> read_libraries(const std::filesystem::path& root,
                                                          const std::vector<std::string>& tops);

/// One sentence for each library of this project that a library below `tops` includes without declaring it,
/// or declares without including it; and for each .cpp file there that no CMakeLists.txt lists. What a header
/// includes must be in `depends`.
[[nodiscard]] std::vector<std::string> undeclared(const std::vector<DeclaredLibrary>& libraries,
                                                  const std::vector<SourceFile>& tree,
                                                  const std::vector<std::string>& tops);

}  // namespace farshade
