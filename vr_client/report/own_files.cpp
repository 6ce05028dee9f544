#include "vr_client/report/own_files.h"

#include <regex>
#include <vector>

namespace farshade {
namespace {

namespace fs = std::filesystem;

/// Removes the regular files in `folder` whose names match `own`. A link is no regular file.
Expected<void> remove_matching(const fs::path& folder, const std::regex& own) {
  std::error_code error;
  std::vector<fs::path> found;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (entry->symlink_status().type() == fs::file_type::regular &&
        std::regex_match(entry->path().filename().string(), own))
      found.push_back(entry->path());
  for (const fs::path& path : found)
    if (!fs::remove(path, error) && error)
      return fail(Fault::Unreadable,
                  "cannot remove " + path.string() + " of an earlier run: " + error.message());
  return {};
}

}  // namespace

Expected<void> remove_own_files(const fs::path& folder) {
  static const std::regex of_run(
      "summary\\.(csv|json)|frames\\.csv|worst\\.png|frame_\\d{4,}_(left|right)\\.png|"
      "worst_\\d{4,}_(left|right)_(shown|reference|difference_x8|source)\\.png");
  static const std::regex of_dump(
      "views\\.json|(left|right)_(mask_traced|mask_shown|source|shown|reference)\\.png|"
      "(left|right)_(lookup_x|lookup_y|distance)\\.pfm");
  static const std::regex dump_name("frame_\\d{4,}");
  if (auto done = remove_matching(folder, of_run); !done) return done;
  std::error_code error;
  std::vector<fs::path> dumps;
  for (fs::directory_iterator entry(folder / "dump", error), end; !error && entry != end;
       entry.increment(error))
    if (entry->symlink_status().type() == fs::file_type::directory &&
        std::regex_match(entry->path().filename().string(), dump_name))
      dumps.push_back(entry->path());
  for (const fs::path& dump : dumps) {
    if (auto done = remove_matching(dump, of_dump); !done) return done;
    fs::remove(dump, error);  // stays if it has other files
  }
  if (!dumps.empty()) fs::remove(folder / "dump", error);
  return {};
}

}  // namespace farshade
