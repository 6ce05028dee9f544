/// ClientEvent: what happened to a client, for the server's log.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "stereo/base/clock.h"
#include "stereo/net/datagram.h"
#include "stereo/sealing/key_file.h"

namespace farshade {

struct ClientEvent {
  enum class Kind : std::uint8_t {
    Welcomed,
    AskedForScene,  ///< the hello named no scene: a doctor asks which one is served
    OtherScene,
    Busy,
    TooManySessions,    ///< its key has as many as the ring allows it
    TooManyHandshakes,  ///< over the limit of all clients, or over its key's share
    Left,               ///< said so
    FellSilent,         ///< for longer than the timeout
    SaidNothing,        ///< has left or fallen silent, and never requested anything
    Replaced,           ///< by a newer session of the same client
    Withdrawn,          ///< its answer is no longer offered
    Displaced,          ///< by a client whose key had fewer sessions, when the server was full
    Revoked,            ///< its key was taken out of the ring
    Expired,            ///< its key's time is over
    NotAdmitted,  ///< has no key of the ring; `who` is the sentence. Strangers can cause any number of these
    KeyExpired,   ///< has proved a key whose time is over
  };
  Kind kind = Kind::Welcomed;
  std::string who;  ///< the name of its key
  Peer client;
  Duration connected{};        ///< of a session that has ended: from its beginning to its last datagram
  std::optional<KeyId> key{};  ///< of a client that has proved it
};

/// Whether somebody should do something about it.
[[nodiscard]] bool is_fault(ClientEvent::Kind kind);

/// One sentence that names the cure if there is one.
[[nodiscard]] std::string in_words(const ClientEvent& event);

}  // namespace farshade
