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

/// Why a client was refused, and what the user can do.
struct Explanation {
  std::string reason, cure;
  [[nodiscard]] std::string sentence() const { return reason + ": " + cure; }
};

/// `scene_hash` is the scene of the client.
[[nodiscard]] Explanation explain(const Refusal& refusal, const ContentHash& scene_hash);

/// The same for a client that sent a Hello with the key named `key` to `server`.
[[nodiscard]] Explanation explain(const OpenRefusal& refusal, const std::string& key, const Peer& server);

}  // namespace farshade
