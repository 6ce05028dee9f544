#include "rt_server/log/client_event.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "stereo/base/check.h"
#include "stereo/net/explain.h"

namespace farshade {
namespace {

struct Words {
  ClientEvent::Kind kind;
  bool is_fault;
  /// Who, where, and for how many seconds it was connected.
  fmt::format_string<std::string, std::string, double> sentence;
};

const Words& words_of(ClientEvent::Kind kind) {
  using enum ClientEvent::Kind;
  static constexpr Words kWords[]{
      {Welcomed, false, "welcomed {0} at {1}"},
      {AskedForScene, false, "{0} at {1} asked which scene is served (vr_client doctor)"},
      {OtherScene, true,
       "refused {0} at {1}: it shows another scene: give both the same scene file, --light, --sun, --ambient "
       "and "
       "--exposure"},
      {Busy, true, "refused {0} at {1}: no room for another client (--sessions)"},
      {TooManySessions, true,
       "refused {0} at {1}: its key has as many sessions as the ring allows it (sessions=)"},
      {TooManyHandshakes, true, "did not answer {0} at {1}: too many handshakes (--handshakes-per-second)"},
      {Left, false, "{0} at {1} left; it was connected for {2:.0f} s"},
      {FellSilent, false, "{0} at {1} left without a word; it was connected for {2:.0f} s"},
      {SaidNothing, false, "{0} at {1} left without a request"},
      {Replaced, false, "{0} at {1} connected anew; its session of {2:.0f} s ended"},
      {Withdrawn, false, "the session of {0} at {1} ended: its answers are no longer offered"},
      {Displaced, false,
       "the session of {0} at {1} ended: its key had the most, and another key needed one (--sessions)"},
      {Revoked, false, "the session of {0} at {1} ended: its key is no longer in the ring"},
      {Expired, false, "the session of {0} at {1} ended: its key has expired (rt_server keygen --until)"},
      {NotAdmitted, true, "{0}"},
      {KeyExpired, true,
       "refused {0} at {1}: the time of its key is over: make a new one (rt_server keygen --until), or "
       "change "
       "until= in the ring"},
  };
  const auto found = std::ranges::find(kWords, kind, &Words::kind);
  check(found != std::end(kWords), "each kind has its words");
  return *found;
}

}  // namespace

bool is_fault(ClientEvent::Kind kind) {
  return words_of(kind).is_fault;
}

std::string in_words(const ClientEvent& event) {
  const Words& words = words_of(event.kind);
  const bool names_key = words.is_fault && event.key.has_value();
  const std::string who =
                        names_key ? fmt::format("{} (key {})", event.who, short_form(*event.key)) : event.who,
                    at = to_string(event.client);
  const double connected_s = seconds_of(event.connected);
  return fmt::vformat(words.sentence, fmt::make_format_args(who, at, connected_s));
}

}  // namespace farshade
