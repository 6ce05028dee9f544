/// Announcer: a server tells the local network where it listens, through the machine's avahi-daemon.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "stereo/base/expected.h"
#include "stereo/net/datagram.h"

namespace farshade {

/// Announces for as long as it lives, in a thread of its own; also after avahi-daemon starts late or again.
/// The name is that of the machine, with a number if it is taken.
class Announcer {
 public:
  /// `listening` has a server's addresses, none of them loopback: each is on all addresses of the machine, or
  /// one that is announced only on its own interface. Of several on one interface and of one family, the
  /// first is announced. `note` gets a sentence when the announcement begins and when it is not possible,
  /// each once; it is called in this thread and in the announcer's.
  Announcer(std::vector<Peer> listening, std::function<void(const std::string&)> note);
  Announcer(const Announcer&) = delete;
  Announcer& operator=(const Announcer&) = delete;
  /// Takes the announcement back.
  ~Announcer();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Unavailable, with a cure, if no avahi-daemon runs on this machine.
[[nodiscard]] Expected<void> can_announce();

}  // namespace farshade
