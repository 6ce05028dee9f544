/// Finds a server that announces itself on the local network (announcer.h), for `--server auto`.
#pragma once

#include <string_view>

#include "stereo/announce/announcement.h"
#include "stereo/base/clock.h"
#include "stereo/base/expected.h"

namespace farshade {

/// How long a search takes at most. It ends after about a second if a server answers.
inline constexpr Duration kSearchTime = std::chrono::seconds(3);

/// Announcements that one search reads. Whoever floods the network with more can hide a server.
inline constexpr std::size_t kMostAnnouncements = 64;

/// Looks for the server that `search` means, and waits. Errors are those of choose_server, and Unavailable if
/// no avahi-daemon runs on this machine.
[[nodiscard]] Expected<FoundServer> find_server(std::string_view search);

}  // namespace farshade
