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

/// The room whose folder holds the file itself. A new subfolder needs a room of its own.
const Room* room_of(const House& house, std::string_view path) {
  const std::string_view folder = path.substr(0, std::min(path.rfind('/'), path.size()));
  const auto at = std::ranges::find(house.rooms, folder, &Room::folder);
  return at == house.rooms.end() ? nullptr : &*at;
}

/// All folders that `room` may include. It contains `room` itself only if the permissions form a cycle.
std::set<std::string_view> allowed_for(const House& house, const Room& room) {
  std::set<std::string_view> allowed;
  const std::function<void(const Room&)> visit = [&](const Room& from) {
    for (const std::string_view folder : from.sees)
      if (allowed.insert(folder).second)
        for (const Room& next : house.rooms)
          if (next.folder == folder) visit(next);
  };
  visit(room);
  return allowed;
}

void find_room_cycles(const House& house, Faults& found) {
  for (const Room& room : house.rooms)
    if (allowed_for(house, room).contains(room.folder))
      found.push_back(std::string(room.folder) + " may include itself through a cycle");
}

void find_forbidden_includes(const House& house, const SourceFile& file, Faults& found) {
  const Room* room = room_of(house, file.path);
  if (!room) {
    found.push_back(file.path + " is in no room");
    return;
  }
  const auto allowed = allowed_for(house, *room);
  for (const std::string& include : file.ours) {
    const Room* const target = room_of(house, include);
    if (!target && !is_below(include, house.guests))
      found.push_back(file.path + " includes \"" + include + "\", which is no path from the root");
    else if (target != room && !(target && allowed.contains(target->folder)))
      found.push_back(file.path + " includes \"" + include + "\", which " + std::string(room->folder) +
                      " may not include");
  }
}

void check_library_place(const House& house, const Library& library, const std::vector<SourceFile>& tree,
                         Faults& found) {
  std::vector<std::string> users;
  for (const SourceFile& file : tree) {
    const bool names =
        std::ranges::any_of(file.theirs, [&](auto& i) { return i.starts_with(library.prefix); });
    if (!names || is_below(file.path, house.guests)) continue;
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

std::vector<SourceFile> read_tree(const fs::path& root, const House& house) {
  std::set<fs::path> tops{fs::path(house.guests)};
  for (const Room& room : house.rooms) tops.insert(*fs::path(room.folder).begin());
  std::vector<SourceFile> tree;
  for (const fs::path& top : tops)
    for (const auto& entry : fs::recursive_directory_iterator(root / top))
      if (entry.path().extension() == ".h" || entry.path().extension() == ".cpp")
        tree.push_back(read_includes(entry.path(), entry.path().lexically_relative(root).generic_string()));
  return tree;
}

std::vector<std::string> faults(const House& house, const std::vector<SourceFile>& tree) {
  Faults found;
  find_room_cycles(house, found);
  for (const SourceFile& file : tree)
    if (!is_below(file.path, house.guests)) find_forbidden_includes(house, file, found);
  for (const Library& library : house.libraries) check_library_place(house, library, tree, found);
  find_include_cycles(tree, found);
  return found;
}

}  // namespace farshade
