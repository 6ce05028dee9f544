#include "tests/integration/declared_libraries.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <sstream>

namespace farshade {
namespace {

namespace fs = std::filesystem;

std::string without_comments(const std::string& cmake) {
  std::istringstream lines(cmake);
  std::string text;
  for (std::string line; std::getline(lines, line);) text += line.substr(0, line.find('#')) + "\n";
  return text;
}

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

/// The arguments of every call of `command`.
std::vector<std::vector<std::string>> calls_of(const std::string& cmake, const std::string& command) {
  std::vector<std::vector<std::string>> calls;
  const std::string opening = command + "(";
  for (std::size_t at = cmake.find(opening); at != std::string::npos; at = cmake.find(opening, at + 1)) {
    const std::size_t first = at + opening.size();
    calls.push_back(words_of(cmake.substr(first, cmake.find(')', first) - first)));
  }
  return calls;
}

DeclaredLibrary library_of(const std::vector<std::string>& words, const std::string& folder) {
  DeclaredLibrary library{
      .name = words.at(0), .folder = folder, .files = {}, .depends = {}, .private_depends = {}};
  std::string list;
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (word == "HEADERS" || word == "SOURCES" || word == "DEPENDS" || word == "PRIVATE_DEPENDS" ||
        word == "COLD")
      list = word;
    else if (list == "DEPENDS")
      library.depends.push_back(word);
    else if (list == "PRIVATE_DEPENDS")
      library.private_depends.push_back(word);
    else
      library.files.push_back(folder + "/" + word);
  }
  return library;
}

/// Which library each header of the project belongs to.
class Owners {
 public:
  explicit Owners(const std::vector<DeclaredLibrary>& libraries) {
    for (const DeclaredLibrary& library : libraries) {
      names_.insert(library.name);
      for (const std::string& file : library.files)
        if (file.ends_with(".h")) of_[file] = library.name;
    }
  }

  [[nodiscard]] std::optional<std::string> of(const std::string& header) const {
    if (header.starts_with("shaders/")) return kShaders;
    const auto at = of_.find(header);
    return at == of_.end() ? std::nullopt : std::optional(at->second);
  }
  [[nodiscard]] bool is_ours(const std::string& library) const {
    return library == kShaders || names_.contains(library);
  }

 private:
  /// The build generates its headers, so that its CMakeLists.txt lists none.
  static constexpr const char* kShaders = "farshade_shaders";
  std::map<std::string, std::string> of_;
  std::set<std::string> names_;
};

bool is_below_any(const std::string& folder, const std::vector<std::string>& tops) {
  return std::ranges::any_of(
      tops, [&](const std::string& top) { return folder == top || folder.starts_with(top + "/"); });
}

void check_library(const DeclaredLibrary& library, const std::map<std::string, const SourceFile*>& files,
                   const Owners& owners, std::vector<std::string>& found) {
  const auto has = [](const std::vector<std::string>& list, const std::string& name) {
    return std::ranges::find(list, name) != list.end();
  };
  std::set<std::string> used;
  for (const std::string& path : library.files) {
    const auto file = files.find(path);
    if (file == files.end()) continue;
    for (const std::string& include : file->second->ours) {
      const auto owner = owners.of(include);
      if (!owner || *owner == library.name) continue;
      used.insert(*owner);
      const bool is_public = has(library.depends, *owner);
      if (path.ends_with(".h") ? !is_public : !is_public && !has(library.private_depends, *owner))
        found.push_back(path + " includes " + include + " of " + *owner + ", which " + library.name +
                        " does not declare");
    }
  }
  // The top of a program also links libraries that implement what another library only declares.
  if (library.folder.find('/') == std::string::npos) return;
  for (const auto* list : {&library.depends, &library.private_depends})
    for (const std::string& name : *list)
      if (owners.is_ours(name) && !used.contains(name))
        found.push_back(library.name + " declares " + name + " and includes none of its headers");
}

}  // namespace

std::vector<DeclaredLibrary> parse_libraries(const std::string& cmake, const std::string& folder) {
  const std::string text = without_comments(cmake);
  std::vector<DeclaredLibrary> libraries;
  for (const auto& words : calls_of(text, "farshade_library")) libraries.push_back(library_of(words, folder));
  for (const auto& words : calls_of(text, "add_executable")) libraries.push_back(library_of(words, folder));
  for (const auto& words : calls_of(text, "target_link_libraries")) {
    const auto at = std::ranges::find(libraries, words.at(0), &DeclaredLibrary::name);
    if (at == libraries.end()) continue;
    at->private_depends.insert(at->private_depends.end(), words.begin() + 2, words.end());
  }
  return libraries;
}

std::vector<DeclaredLibrary> read_libraries(const fs::path& root, const std::vector<std::string>& tops) {
  std::vector<DeclaredLibrary> all;
  for (const std::string& top : tops)
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      if (entry.path().filename() != "CMakeLists.txt") continue;
      std::ifstream file(entry.path());
      const std::string text{std::istreambuf_iterator<char>(file), {}};
      const std::string folder = entry.path().parent_path().lexically_relative(root).generic_string();
      std::ranges::move(parse_libraries(text, folder), std::back_inserter(all));
    }
  return all;
}

std::vector<std::string> undeclared(const std::vector<DeclaredLibrary>& libraries,
                                    const std::vector<SourceFile>& tree,
                                    const std::vector<std::string>& tops) {
  std::map<std::string, const SourceFile*> files;
  for (const SourceFile& file : tree) files[file.path] = &file;
  const Owners owners(libraries);
  std::vector<std::string> found;
  std::set<std::string> listed;
  for (const DeclaredLibrary& library : libraries) {
    listed.insert(library.files.begin(), library.files.end());
    if (is_below_any(library.folder, tops)) check_library(library, files, owners, found);
  }
  for (const SourceFile& file : tree)
    if (file.path.ends_with(".cpp") && is_below_any(file.path, tops) && !listed.contains(file.path))
      found.push_back(file.path + " is in no library");
  return found;
}

}  // namespace farshade
