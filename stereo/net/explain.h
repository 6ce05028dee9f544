/// The sentences that people read on either side when a server refuses a client.
#pragma once

#include <string>

#include "stereo/net/datagram.h"
#include "stereo/wire/envelope.h"

namespace farshade {

/// The first eight hexadecimal digits: enough to tell two scenes apart by eye.
[[nodiscard]] std::string short_form(const ContentHash& hash);

/// In a few words, for a log.
[[nodiscard]] std::string_view name_of(RefusalReason reason);

/// Why a client that shows `scene_hash` was refused, and the cure.
[[nodiscard]] std::string explain(const Refusal& refusal, const ContentHash& scene_hash);

/// The same for a client that said hello with the key named `key` to `server`.
[[nodiscard]] std::string explain(const OpenRefusal& refusal, const std::string& key, const Peer& server);

}  // namespace farshade
