/// Sentences for people, on either side, when a server refuses a client.
#pragma once

#include <string>

#include "stereo/net/datagram.h"
#include "stereo/sealing/envelope.h"

namespace farshade {

/// The first eight hexadecimal digits, enough for people to distinguish two scenes.
[[nodiscard]] std::string short_form(const ContentHash& hash);
[[nodiscard]] std::string short_form(const KeyId& id);

/// Why a client was refused, and what the user can do.
struct Explanation {
  std::string reason, cure;
  [[nodiscard]] std::string sentence() const { return reason + ": " + cure; }
};

/// `scene_hash` is the scene of the client.
[[nodiscard]] Explanation explain(const Refusal& refusal, const ContentHash& scene_hash);

/// The same for a client that sent a Hello with `key` to `server`.
[[nodiscard]] Explanation explain(const OpenRefusal& refusal, const SharedKey& key, const Peer& server);

/// The same for a client whose session `server` has ended.
[[nodiscard]] Explanation explain(const Goodbye& goodbye, const SharedKey& key, const Peer& server);

/// For the server's log: why it does not admit the client at `client`, whose hello names the key `id`. The
/// client is told less (OpenRefusal).
[[nodiscard]] std::string explain(const KeyId& id, const KeyRing& ring, const Peer& client);

}  // namespace farshade
