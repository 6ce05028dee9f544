/// Sentences for users, on either side, when a server refuses a client.
#pragma once

#include <string>

#include "stereo/net/datagram.h"
#include "stereo/wire/envelope.h"

namespace farshade {

/// The first eight hexadecimal digits, enough for people to distinguish two scenes.
[[nodiscard]] std::string short_form(const ContentHash& hash);

/// A few words for a log.
[[nodiscard]] std::string_view name_of(RefusalReason reason);

/// The reason why a client with scene `scene_hash` was refused, and how to fix it.
[[nodiscard]] std::string explain(const Refusal& refusal, const ContentHash& scene_hash);

/// The same for a client that sent a Hello with the key named `key` to `server`.
[[nodiscard]] std::string explain(const OpenRefusal& refusal, const std::string& key, const Peer& server);

}  // namespace farshade
