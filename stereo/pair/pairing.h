/// Pairing: a client brings its own new key to a server's ring over TCP, instead of a file that a person
/// copies. A code that works once authenticates both sides (pairing_code.h).
/// The handshake is that of the other transports, with the code's key in place of a shared key and with a
/// label of its own (sealed_stream.h), so that nothing of one transport is of use on another. X25519 with
/// ephemeral keys encrypts: who hears everything learns no key, not even with the code. Without the code
/// nobody can answer in the place of either side.
#pragma once

#include <functional>

#include "stereo/net/tcp.h"
#include "stereo/pair/pairing_code.h"

namespace farshade {

struct PairingLimits {
  Duration life = std::chrono::minutes(5);      ///< of the code
  Duration patience = std::chrono::seconds(2);  ///< with a connection, until its client's key has come
  int guesses = 16;                             ///< wrong codes until the pairing ends
};

struct PairedClient {
  SharedKey key;
  Peer client;
};

/// Puts a client's key into the ring. Its Fault::Unavailable means: the name or the secret is taken.
using AddKey = std::function<Expected<void>(const SharedKey&)>;

/// The server's side: waits for the one client with `code`, adds its key and closes the port. Clients take
/// turns. A replayed Hello and a client whose name is taken do not use up the code. Errors: Missing if the
/// code's life ends, Mismatch after too many wrong codes, Interrupted if `stopped` says so, and the error of
/// `add` if it is not Unavailable.
[[nodiscard]] Expected<PairedClient> wait_for_pairing(TcpListener listener, const PairingCode& code,
                                                      const AddKey& add, const PairingLimits& limits = {},
                                                      const std::function<bool()>& stopped = {});

/// The client's side: gives `key` to the server that shows `code`. When it returns, the server's ring has the
/// key. Errors are sentences with a cure: Missing if nobody waits there, Mismatch for a wrong code,
/// Unavailable if the server has a key of this name, Unreadable if its ring cannot be written.
[[nodiscard]] Expected<void> pair_with(const PairingCode& code, const SharedKey& key, const Waiting& waiting);

}  // namespace farshade
