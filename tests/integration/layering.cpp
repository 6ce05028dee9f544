#include "tests/integration/layering.h"

#include <algorithm>
#include <fstream>
#include <functional>
#include <map>
#include <set>

namespace farshade {
namespace {

namespace fs = std::filesystem;
using Faults = std::vector<std::string>;

bool is_below(std::string_view path, std::string_view folder) {
  return path.starts_with(folder) && (path.size() == folder.size() || path[folder.size()] == '/');
}

/// The layer whose folder holds the file itself. A new subfolder needs a layer of its own.
const Layer* layer_of(const Layering& layering, std::string_view path) {
  const std::string_view folder = path.substr(0, std::min(path.rfind('/'), path.size()));
  const auto at = std::ranges::find(layering.layers, folder, &Layer::folder);
  return at == layering.layers.end() ? nullptr : &*at;
}

/// All folders that `layer` may include. It contains `layer` itself only if the permissions form a cycle.
std::set<std::string_view> allowed_for(const Layering& layering, const Layer& layer) {
  std::set<std::string_view> allowed;
  const std::function<void(const Layer&)> visit = [&](const Layer& from) {
    for (const std::string_view folder : from.sees)
      if (allowed.insert(folder).second)
        for (const Layer& next : layering.layers)
          if (next.folder == folder) visit(next);
  };
  visit(layer);
  return allowed;
}

void find_layer_cycles(const Layering& layering, Faults& found) {
  for (const Layer& layer : layering.layers)
    if (allowed_for(layering, layer).contains(layer.folder))
      found.push_back(std::string(layer.folder) + " may include itself through a cycle");
}

void find_forbidden_includes(const Layering& layering, const SourceFile& file, Faults& found) {
  const Layer* layer = layer_of(layering, file.path);
  if (!layer) {
    found.push_back(file.path + " is in no layer");
    return;
  }
  const auto allowed = allowed_for(layering, *layer);
  for (const std::string& include : file.ours) {
    const Layer* const target = layer_of(layering, include);
    if (!target && !is_below(include, layering.unrestricted))
      found.push_back(file.path + " includes \"" + include + "\", which is no path from the root");
    else if (target != layer && !(target && allowed.contains(target->folder)))
      found.push_back(file.path + " includes \"" + include + "\", which " + std::string(layer->folder) +
                      " may not include");
  }
}

void check_library_place(const Layering& layering, const Library& library,
                         const std::vector<SourceFile>& tree, Faults& found) {
  std::vector<std::string> users;
  for (const SourceFile& file : tree) {
    const bool names =
        std::ranges::any_of(file.theirs, [&](auto& i) { return i.starts_with(library.prefix); });
    if (!names || is_below(file.path, layering.unrestricted)) continue;
    users.push_back(file.path);
    if (!is_below(file.path, library.folder))
      found.push_back(file.path + " names <" + std::string(library.prefix) + ">, which belongs to " +
                      std::string(library.folder));
  }
  if (users.size() <= library.files) return;
  std::string sentence =
      "<" + std::string(library.prefix) + "> is named by more than " + std::to_string(library.files) + ":";
  for (const std::string& user : users) sentence += " " + user;
  found.push_back(sentence);
}

void find_include_cycles(const std::vector<SourceFile>& tree, Faults& found) {
  enum class Mark { New, Open, Done };
  struct Node {
    const SourceFile* file;
    Mark mark = Mark::New;
  };
  std::map<std::string, Node> nodes;
  for (const SourceFile& file : tree) nodes[file.path] = {&file};
  const std::function<void(Node&)> visit = [&](Node& node) {
    node.mark = Mark::Open;
    for (const std::string& include : node.file->ours) {
      const auto at = nodes.find(include);
      if (at == nodes.end()) continue;
      if (at->second.mark == Mark::Open) found.push_back(node.file->path + " closes a cycle with " + include);
      if (at->second.mark == Mark::New) visit(at->second);
    }
    node.mark = Mark::Done;
  };
  for (auto& [path, node] : nodes)
    if (node.mark == Mark::New) visit(node);
}

/// The part of `text` after `word` and the blanks around it. Empty if `text` does not begin with `word`.
std::string_view after(std::string_view text, std::string_view word) {
  constexpr std::string_view blanks = " \t";
  text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
  if (!text.starts_with(word)) return {};
  text.remove_prefix(word.size());
  text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
  return text;
}

SourceFile read_includes(const fs::path& path, std::string from_root) {
  SourceFile file{std::move(from_root), {}, {}};
  std::ifstream text(path);
  for (std::string line; std::getline(text, line);) {
    const std::string_view named = after(after(line, "#"), "include");
    const std::size_t end = named.find_first_of("\">", 1);
    if (named.empty() || end == std::string_view::npos) continue;
    (named[0] == '<' ? file.theirs : file.ours).emplace_back(named.substr(1, end - 1));
  }
  return file;
}

}  // namespace

std::vector<SourceFile> read_tree(const fs::path& root, const Layering& layering) {
  std::set<fs::path> tops{fs::path(layering.unrestricted)};
  for (const Layer& layer : layering.layers) tops.insert(*fs::path(layer.folder).begin());
  std::vector<SourceFile> tree;
  for (const fs::path& top : tops)
    for (const auto& entry : fs::recursive_directory_iterator(root / top))
      if (entry.path().extension() == ".h" || entry.path().extension() == ".cpp")
        tree.push_back(read_includes(entry.path(), entry.path().lexically_relative(root).generic_string()));
  return tree;
}

std::vector<std::string> faults(const Layering& layering, const std::vector<SourceFile>& tree) {
  Faults found;
  find_layer_cycles(layering, found);
  for (const SourceFile& file : tree)
    if (!is_below(file.path, layering.unrestricted)) find_forbidden_includes(layering, file, found);
  for (const Library& library : layering.libraries) check_library_place(layering, library, tree, found);
  find_include_cycles(tree, found);
  return found;
}

}  // namespace farshade
