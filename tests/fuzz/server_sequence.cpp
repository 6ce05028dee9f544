// A server with two live sessions, and an attacker who reads every datagram, sends any bytes from any
// address, and withholds datagrams. The input is a list of steps in virtual time. Afterwards the genuine
// clients must get their masks bit for bit, with the first request if none of their datagrams was withheld.
// The server must have counted each of their requests once and no other, and sent no stranger more bytes than
// it received.
#include <deque>

#include "tests/fuzz/attacked_link.h"
#include "tests/support/manual_clock.h"

using namespace farshade;
using namespace std::chrono_literals;
using fuzz::Bytes;

namespace {

constexpr std::uint32_t kGenuine = 2, kPlaces = 6;  ///< genuine clients, and addresses in all
constexpr std::size_t kMostSessions = 4;

class Conversation {
 public:
  Conversation();
  void step(fuzz::Choices& choices);
  void finish();

 private:
  [[nodiscard]] Peer server() { return wire_.server().local(); }
  void say_from(std::uint32_t place, const Bytes& datagram);
  void knock(std::uint32_t place, const SharedKey& key);
  std::optional<Retry> retry_to(std::uint32_t place);
  void pass(Duration time);
  void check_server();

  ManualClock clock_;
  VirtualLink wire_{clock_, {}, kPlaces};
  std::vector<Bytes> recorded_;
  fuzz::Tap server_tap_{wire_.server(), recorded_};
  const std::vector<SharedKey> ring_{fuzz::key_named("left"), fuzz::key_named("right"),
                                     fuzz::key_named("new")};
  ServerCore core_{fuzz::kServed, ring_,  masks_from(fuzz::paint),
                   server_tap_,   clock_, {.sessions = kMostSessions}};
  std::deque<fuzz::GenuineClient> clients_;
  std::map<Peer, std::uint64_t> bytes_from_;  ///< bytes sent by strangers
  bool withheld_ = false;                     ///< a datagram of a genuine client or of the server
};

Conversation::Conversation() {
  wire_.while_waiting([this] { fuzz::serve(core_); }, [this] { return core_.next_due(); });
  for (std::uint32_t i = 0; i < kGenuine; ++i) {
    clients_.emplace_back(wire_.client(i), clock_, server(), ring_[i].name, recorded_);
    check(clients_[i].gets_masks(1, 100ms), "an undisturbed client gets its masks");
  }
}

void Conversation::say_from(std::uint32_t place, const Bytes& datagram) {
  if (place >= kGenuine) bytes_from_[wire_.client(place).local()] += datagram.size();
  wire_.client(place).send(server(), datagram);
  fuzz::serve(core_);
}

std::optional<Retry> Conversation::retry_to(std::uint32_t place) {
  std::array<std::byte, kMaxDatagram_bytes> buffer;
  while (const auto datagram = wire_.client(place).receive(buffer, 0s)) {
    const auto envelope = open_server_envelope(datagram->bytes);
    check(envelope.has_value(), "the server sends only valid datagrams");
    if (const auto* retry = std::get_if<Retry>(&*envelope)) return *retry;
  }
  return std::nullopt;
}

/// A new client says hello, with or without a key of the ring.
void Conversation::knock(std::uint32_t place, const SharedKey& key) {
  ClientHandshake handshake(key, fuzz::kServed.scene_hash);
  Bytes hello;
  handshake.write_hello(hello);
  recorded_.push_back(hello);
  say_from(place, hello);
  const std::optional<Retry> retry = retry_to(place);
  if (!retry || !handshake.take(*retry)) return;
  handshake.write_hello(hello);
  recorded_.push_back(hello);
  say_from(place, hello);
}

void Conversation::pass(Duration time) {
  clients_[0].link.listen(time);
  for (fuzz::GenuineClient& client : clients_) {
    client.link.poll();
    client.check_masks();
  }
}

void Conversation::step(fuzz::Choices& choices) {
  enum Step : std::uint32_t { Say, Repeat, Forge, Request, Pass, Withhold, Move, Knock, kSteps };
  const std::uint32_t kind = choices.up_to(kSteps - 1), place = choices.up_to(kPlaces - 1);
  const std::uint32_t client = place % kGenuine;
  if (kind == Say) {
    const auto bytes = choices.bytes(choices.up_to(255));
    say_from(place, Bytes(bytes.begin(), bytes.end()));
  } else if (kind == Repeat || kind == Forge) {
    say_from(place, fuzz::replayed(recorded_, choices, kind == Forge ? 8 : 0));
  } else if (kind == Request) {
    clients_[client].ask();
    fuzz::serve(core_);
    clients_[client].link.poll();
  } else if (kind == Pass) {
    pass(std::chrono::milliseconds(choices.up_to(255)));
  } else if (kind == Withhold) {
    (place < kGenuine ? clients_[client].tap : server_tap_).hold_next = 1;
    withheld_ = true;
  } else if (kind == Move) {
    wire_.move_client(client);
    withheld_ = true;
  } else {
    knock(2 + place % (kPlaces - 2), choices.up_to(1) == 0 ? ring_[2] : fuzz::key_named("nobody"));
  }
  check_server();
}

void Conversation::check_server() {
  const ServerCounters counters = core_.counters();
  std::uint64_t requests = 0;
  for (const fuzz::GenuineClient& client : clients_) requests += client.requests;
  if (withheld_)
    check(counters.sessions.requests <= requests, "each request counts once at most");
  else
    check_eq(counters.sessions.requests, requests, "requests: each counts once");
  check(counters.sessions_open <= kMostSessions, "no more sessions than allowed");
  for (std::uint32_t place = kGenuine; place < kPlaces; ++place) {
    const Peer peer = wire_.client(place).local();
    check(server_tap_.bytes_to[peer] <= bytes_from_[peer], "a stranger receives no more bytes than it sent");
  }
}

void Conversation::finish() {
  server_tap_.hold_next = 0;
  for (fuzz::GenuineClient& client : clients_) client.tap.hold_next = 0;
  for (fuzz::GenuineClient& client : clients_) {
    check(client.gets_masks(withheld_ ? 150 : 1, 100ms), "a genuine client gets its masks");
    check(client.link.last_received().has_value() && !client.link.refused(), "and is in session");
    if (!withheld_) check_eq(client.link.counters().sessions, 1u, "sessions: the first one");
  }
  check_server();
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return fuzz::converse<Conversation>(data, size);
}
