// Handshake under an attacker who reads and changes every datagram. A client must accept only an unchanged
// accept. The gate must admit only an unchanged hello with a valid cookie and proof. No answer may be longer
// than the hello. One handshake is made at start-up; the input is a list of changes to its datagrams.
#include "stereo/sealing/handshake.h"

#include <algorithm>

#include "rt_server/admission/gate.h"
#include "tests/fuzz/edits.h"
#include "tests/fuzz/target.h"
#include "tests/support/fixed_random.h"

using namespace farshade;

namespace {

using Bytes = std::vector<std::byte>;

const Welcome kServed{{1, 2, 3}, 3};

Peer peer(std::uint32_t host) {
  return {{0x20, 0x01, 0x0d, 0xb8, static_cast<std::uint8_t>(host)}, 0, 7447};
}

Hello hello_of(const Bytes& datagram) {
  return std::get<Hello>(open_client_envelope(datagram).value());
}

/// The datagrams of a client with a key of the ring, and of an outsider with another key.
struct Genuine {
  SharedKey key{.name = "desk", .secret = {7}}, other{.name = "wrong", .secret = {8}};
  Time completed = Time(std::chrono::seconds(100));
  Gate gate{{key}, 1e9};
  ClientHandshake client{key, kServed.scene_hash}, outsider{other, kServed.scene_hash};
  Bytes bare, cookied,
      outside;  ///< hellos: without a cookie, with a cookie, and the outsider's with a cookie
  Accepted accepted;

  Genuine() {
    client.write_hello(bare);
    cookied = with_cookie(client, bare);
    outsider.write_hello(outside);
    outside = with_cookie(outsider, outside);
    accepted = accept(hello_of(cookied), cookied, key, kServed).value();
  }

  /// Sends `hello` to the gate from peer 0. Returns the hello with the cookie of the answer.
  Bytes with_cookie(ClientHandshake& handshake, const Bytes& hello) {
    Bytes answer, again;
    check(gate.admit(peer(0), hello_of(hello), hello, completed, answer) == nullptr,
          "the first hello gets a cookie");
    check(handshake.take(std::get<Retry>(open_server_envelope(answer).value())), "a retry is accepted");
    handshake.write_hello(again);
    return again;
  }
};

Genuine& genuine() {
  static Genuine made = (fix_random(1), Genuine());
  return made;
}

/// Gives the accept, changed or not, to its client.
void connect(fuzz::Choices& choices) {
  const Bytes datagram = fuzz::edited(genuine().accepted.datagram, choices);
  const auto envelope = open_server_envelope(datagram);
  const auto* const accept = envelope ? std::get_if<Accept>(&*envelope) : nullptr;
  const auto completed = accept != nullptr ? genuine().client.take(*accept, datagram) : std::nullopt;
  check_eq(completed.has_value(), datagram == genuine().accepted.datagram, "accepted only if unchanged");
  if (!completed) return;
  check(std::get<Welcome>(completed->answer) == kServed, "the client reads what the server wrote");
  const SessionKeys& server = genuine().accepted.keys;
  check(completed->keys.session == server.session && completed->keys.to_server == server.to_server &&
            completed->keys.to_client == server.to_client,
        "both sides hold the same keys");
}

/// A retry with any cookie must not prevent the client from accepting the server's accept.
void retry(fuzz::Choices& choices) {
  ClientHandshake client = genuine().client;
  Bytes datagram;
  encode(Retry{client.echo(), {}}, datagram);
  datagram = fuzz::edited(datagram, choices);
  const auto envelope = open_server_envelope(datagram);
  const auto* const said = envelope ? std::get_if<Retry>(&*envelope) : nullptr;
  if (said == nullptr) return;
  check_eq(client.take(*said), said->echo == client.echo(), "a retry for this hello");
  const Bytes& accepted = genuine().accepted.datagram;
  const auto answer = open_server_envelope(accepted);
  check(client.take(std::get<Accept>(*answer), accepted).has_value(), "an earlier accept still opens");
}

/// Sends a hello of one of the three, changed or not, from any address, after any time.
void knock(fuzz::Choices& choices) {
  const std::array<const Bytes*, 3> hellos{&genuine().bare, &genuine().cookied, &genuine().outside};
  const Bytes& base = *hellos[choices.up_to(2)];
  const std::uint32_t host = choices.up_to(3);
  const Duration later = std::chrono::milliseconds(choices.up_to(20'000));
  const Bytes datagram = fuzz::edited(base, choices);
  const auto envelope = open_client_envelope(datagram);
  if (!envelope) return;
  Bytes answer;
  const SharedKey* admitted = nullptr;
  if (const auto* hello = std::get_if<Hello>(&*envelope))
    admitted = genuine().gate.admit(peer(host), *hello, datagram, genuine().completed + later, answer);
  else if (const auto* foreign = std::get_if<ForeignHello>(&*envelope))
    genuine().gate.refuse_version(*foreign, answer);
  const bool proved = datagram == genuine().cookied && host == 0;
  if (admitted != nullptr) check(proved && later <= kCookieLife, "only with key, address and a valid cookie");
  if (proved && later < kCookiePeriod) check(admitted != nullptr, "a valid hello is admitted");
  check(answer.size() <= datagram.size(), "no answer is longer than the hello");
  if (!answer.empty()) check(open_server_envelope(answer).has_value(), "an answer is a valid datagram");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Choices choices(data, size);
  const std::uint32_t form = choices.up_to(2);
  if (form == 0) connect(choices);
  if (form == 1) retry(choices);
  if (form == 2) knock(choices);
  return 0;
}
