/// The user's folders for files of these programs, by the XDG Base Directory Specification 0.8. They may not
/// exist.
#pragma once

#include <filesystem>

namespace farshade {

/// $XDG_CONFIG_HOME/farshade, else ~/.config/farshade.
[[nodiscard]] std::filesystem::path config_folder();

/// $XDG_CACHE_HOME/farshade, else ~/.cache/farshade. Its files can be deleted at any time.
[[nodiscard]] std::filesystem::path cache_folder();

/// $XDG_STATE_HOME/farshade, else ~/.local/state/farshade: what a program remembers from run to run.
[[nodiscard]] std::filesystem::path state_folder();

}  // namespace farshade
