#include "stereo/base/user_folders.h"

#include <pwd.h>
#include <unistd.h>

#include <cstdlib>

namespace farshade {
namespace {

namespace fs = std::filesystem;

/// The folder that the variable names; a relative one must be ignored. Else a folder in the user's home.
fs::path user_folder(const char* variable, const char* in_home) {
  if (const char* base = std::getenv(variable); base != nullptr && fs::path(base).is_absolute())
    return fs::path(base) / "farshade";
  const char* home = std::getenv("HOME");
  if (home == nullptr || *home == '\0') {
    const passwd* user = ::getpwuid(::geteuid());
    home = user != nullptr ? user->pw_dir : "/";
  }
  return fs::path(home) / in_home / "farshade";
}

}  // namespace

fs::path config_folder() {
  return user_folder("XDG_CONFIG_HOME", ".config");
}

fs::path cache_folder() {
  return user_folder("XDG_CACHE_HOME", ".cache");
}

fs::path state_folder() {
  return user_folder("XDG_STATE_HOME", ".local/state");
}

}  // namespace farshade
