// A client with a live session, and an attacker who reads every datagram, sends any bytes from the server's
// address, and withholds datagrams. The input is a list of steps in virtual time. Afterwards the client must
// get its next masks bit for bit and keep its session. It may begin another one only if datagrams were
// withheld, or if it received a NoSession. It must accept no slice twice.
#include "tests/fuzz/attacked_link.h"
#include "tests/support/manual_clock.h"

using namespace farshade;
using namespace std::chrono_literals;
using fuzz::Bytes;

namespace {

class Conversation {
 public:
  Conversation();
  void step(fuzz::Choices& choices);
  void finish();

 private:
  void say(const Bytes& datagram);
  void make(fuzz::Choices& choices);
  /// The newest recorded datagram of this type, of either side.
  template <class Envelope>
  [[nodiscard]] Envelope newest(auto open) const;
  void check_client() const;

  ManualClock clock_;
  VirtualLink wire_{clock_, {}};
  std::vector<Bytes> recorded_;
  fuzz::Tap server_tap_{wire_.server(), recorded_};
  ServerCore core_{fuzz::kServed,  {fuzz::key_named("desk")}, masks_from(fuzz::paint), server_tap_, clock_,
                   {.sessions = 4}};
  std::optional<fuzz::GenuineClient> client_;
  bool withheld_ = false;  ///< a datagram of the client or the server
  bool disowned_ = false;  ///< the client received a NoSession for its session
};

Conversation::Conversation() {
  wire_.while_waiting([this] { fuzz::serve(core_); }, [this] { return core_.next_due(); });
  client_.emplace(wire_.client(), clock_, wire_.server().local(), "desk", recorded_);
  check(client_->gets_masks(1, 100ms), "an undisturbed client gets its masks");
}

/// Sends from the server's address, past the tap.
void Conversation::say(const Bytes& datagram) {
  const auto envelope = open_server_envelope(datagram);
  if (envelope && std::holds_alternative<NoSession>(*envelope)) disowned_ = true;
  wire_.server().send(wire_.client().local(), datagram);
  client_->link.poll();
}

template <class Envelope>
Envelope Conversation::newest(auto open) const {
  for (auto datagram = recorded_.rbegin(); datagram != recorded_.rend(); ++datagram)
    if (const auto envelope = open(*datagram))
      if (const auto* found = std::get_if<Envelope>(&*envelope)) return *found;
  check_failed("one was recorded", "", CallPlace::current());
}

/// Sends an unsealed message that is as correct as an attacker can make it.
void Conversation::make(fuzz::Choices& choices) {
  const HelloEcho echo = echo_of(newest<Hello>(open_client_envelope).client);
  const SessionId session = newest<Sealed>(open_server_envelope).session;
  const auto number = static_cast<std::uint8_t>(choices.up_to(255));
  const Bytes sealed(16 + choices.up_to(64), static_cast<std::byte>(number));
  Bytes datagram;
  switch (choices.up_to(5)) {
    case 0:
      encode(NoSession{session}, datagram);
      break;
    case 1:
      encode(Retry{echo, {number}}, datagram);
      break;
    case 2:
      encode(OpenRefusal{.reason = RefusalReason::UnknownKey, .echo = echo}, datagram);
      break;
    case 3:
      encode(OpenRefusal{.version = number, .echo = echo}, datagram);
      break;
    case 4:
      encode(Accept{echo, session, {number}, sealed}, datagram);
      break;
    default:
      encode(Sealed{session, number, sealed}, datagram);
  }
  say(datagram);
}

void Conversation::step(fuzz::Choices& choices) {
  enum Step : std::uint32_t { Say, Repeat, Forge, Make, Request, Pass, Withhold, kSteps };
  const std::uint32_t kind = choices.up_to(kSteps - 1);
  if (kind == Say) {
    const auto bytes = choices.bytes(choices.up_to(255));
    say(Bytes(bytes.begin(), bytes.end()));
  } else if (kind == Repeat || kind == Forge) {
    say(fuzz::replayed(recorded_, choices, kind == Forge ? 8 : 0));
  } else if (kind == Make) {
    make(choices);
  } else if (kind == Request) {
    client_->ask();
    fuzz::serve(core_);
    client_->link.poll();
  } else if (kind == Pass) {
    client_->link.listen(std::chrono::milliseconds(choices.up_to(255)));
  } else {
    (choices.up_to(1) == 0 ? server_tap_ : client_->tap).hold_next = 1;
    withheld_ = true;
  }
  check_client();
}

void Conversation::check_client() const {
  client_->check_masks();
  const NetworkLink::Counters counters = client_->link.counters();
  check_eq(counters.assembler.duplicates, 0u, "slices accepted twice");
  check_eq(counters.assembler.refused.total(), 0u, "malformed slices");
  check(!client_->link.refused(), "only the server can refuse");
  if (!withheld_ && !disowned_) {
    check(client_->link.last_received().has_value(), "the session lives on");
    check_eq(counters.sessions, 1u, "sessions: the first one");
    check_eq(counters.missing, 0u, "missing: nothing was withheld");
  }
}

void Conversation::finish() {
  server_tap_.hold_next = client_->tap.hold_next = 0;
  check(client_->gets_masks(withheld_ || disowned_ ? 60 : 1, 100ms), "the client gets its masks");
  check(client_->link.last_received().has_value(), "and is in session");
  check_client();
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return fuzz::converse<Conversation>(data, size);
}
