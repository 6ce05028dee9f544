#include "rt_server/log/client_event.h"

#include <spdlog/fmt/fmt.h>

#include "stereo/net/explain.h"

namespace farshade {

bool is_fault(ClientEvent::Kind kind) {
  using enum ClientEvent::Kind;
  return kind == OtherScene || kind == Busy || kind == TooManySessions || kind == TooManyHandshakes ||
         kind == NotAdmitted || kind == KeyExpired;
}

std::string in_words(const ClientEvent& event) {
  using enum ClientEvent::Kind;
  std::string who = is_fault(event.kind) && event.key
                        ? fmt::format("{} (key {})", event.who, short_form(*event.key))
                        : event.who;
  const std::string at = to_string(event.client);
  switch (event.kind) {
    case Welcomed:
      return fmt::format("welcomed {} at {}", who, at);
    case AskedForScene:
      return fmt::format("{} at {} asked which scene is served (vr_client doctor)", who, at);
    case OtherScene:
      return fmt::format(
          "refused {} at {}: it shows another scene: give both the same scene file, --light, --sun, "
          "--ambient and --exposure",
          who, at);
    case Busy:
      return fmt::format("refused {} at {}: no room for another client (--sessions)", who, at);
    case TooManySessions:
      return fmt::format("refused {} at {}: its key has as many sessions as the ring allows it (sessions=)",
                         who, at);
    case TooManyHandshakes:
      return fmt::format("did not answer {} at {}: too many handshakes (--handshakes-per-second)", who, at);
    case KeyExpired:
      return fmt::format(
          "refused {} at {}: the time of its key is over: make a new one (rt_server keygen --until), or "
          "change "
          "until= in the ring",
          who, at);
    case Left:
      return fmt::format("{} at {} left; it was connected for {:.0f} s", who, at,
                         seconds_of(event.connected));
    case FellSilent:
      return fmt::format("{} at {} left without a word; it was connected for {:.0f} s", who, at,
                         seconds_of(event.connected));
    case SaidNothing:
      return fmt::format("{} at {} left without a request", who, at);
    case Replaced:
      return fmt::format("{} at {} connected anew; its session of {:.0f} s ended", who, at,
                         seconds_of(event.connected));
    case Withdrawn:
      return fmt::format("the session of {} at {} ended: its answers are no longer offered", who, at);
    case Displaced:
      return fmt::format(
          "the session of {} at {} ended: its key had the most, and another key needed one (--sessions)", who,
          at);
    case Revoked:
      return fmt::format("the session of {} at {} ended: its key is no longer in the ring", who, at);
    case Expired:
      return fmt::format("the session of {} at {} ended: its key has expired (rt_server keygen --until)", who,
                         at);
    case NotAdmitted:
      return who;
  }
  return {};
}

}  // namespace farshade
