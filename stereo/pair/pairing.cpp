#include "stereo/pair/pairing.h"

#include "stereo/net/sealed_stream.h"
#include "stereo/pair/pairing_messages.h"

namespace farshade {
namespace {

/// What came of one connection.
enum class Visit : std::uint8_t { Paired, WrongCode, Nothing };

PairingAnswer answer_to(const Expected<void>& added) {
  if (added) return PairingAnswer::Added;
  return added.error().fault == Fault::Unavailable ? PairingAnswer::Taken : PairingAnswer::NotWritten;
}

/// Serves one client. An error is that of `add`.
Expected<Visit> serve_client(TcpStream stream, const KeyRing& ring, const AddKey& add, const Waiting& waiting,
                             PairedClient& paired) {
  paired.client = stream.peer();
  auto connected = SealedStream::admit(std::move(stream), StreamPurpose::Pairing, ring, Welcome{}, waiting);
  if (!connected) return connected.error().fault == Fault::Mismatch ? Visit::WrongCode : Visit::Nothing;
  const auto message = connected->receive(waiting);
  const auto key = message ? decode_pairing_request(*message) : refuse(WireRefusal::Truncated);
  if (!key) return Visit::Nothing;
  const Expected<void> added = add(*key);
  const PairingAnswer answer = answer_to(added);
  connected->add(encode(answer));
  static_cast<void>(connected->flush(waiting));  // the key is in the ring, whether or not the client hears it
  paired.key = *key;
  if (answer == PairingAnswer::NotWritten) return tl::unexpected(added.error());
  return answer == PairingAnswer::Added ? Visit::Paired : Visit::Nothing;
}

}  // namespace

Expected<PairedClient> wait_for_pairing(TcpListener listener, const PairingCode& code, const AddKey& add,
                                        const PairingLimits& limits, const std::function<bool()>& stopped) {
  const SharedKey key = one_time_key(code);
  const KeyRing ring = by_id({key});
  const SteadyClock clock;
  const Time end = clock.now() + limits.life;
  for (int guesses = 0; guesses < limits.guesses;) {
    std::optional<TcpStream> stream = listener.accept({end, stopped});
    if (stopped && stopped()) return fail(Fault::Interrupted, "stopped before a client was paired");
    if (clock.now() >= end)
      return fail(Fault::Missing, "no client came with the code in time, and the code is of no use any more");
    if (!stream) continue;
    PairedClient paired;
    const Expected<Visit> visit = serve_client(
        *std::move(stream), ring, add, {std::min(end, clock.now() + limits.patience), stopped}, paired);
    if (!visit) return tl::unexpected(visit.error());
    if (*visit == Visit::Paired) return paired;
    if (*visit == Visit::WrongCode) ++guesses;
  }
  return fail(Fault::Mismatch, "clients came with " + std::to_string(limits.guesses) +
                                   " wrong codes: somebody guesses, so this code is of no use any more");
}

Expected<void> pair_with(const PairingCode& code, const SharedKey& key, const Waiting& waiting) {
  const Expected<std::vector<Peer>> servers = resolve_tcp(code.address, kPairingPort);
  if (!servers) return tl::unexpected(servers.error());
  Expected<TcpStream> stream = connect_tcp(*servers, waiting);
  if (!stream)
    return fail(Fault::Missing,
                stream.error().what +
                    ": nobody waits there any more, or a firewall is in between. Start rt_server "
                    "pair again, and open its TCP port");
  const std::string where = to_string(stream->peer());
  auto connected =
      SealedStream::connect(*std::move(stream), StreamPurpose::Pairing, one_time_key(code), waiting);
  if (!connected) return tl::unexpected(connected.error());
  connected->add(encode_pairing_request(key));
  if (auto sent = connected->flush(waiting); !sent) return tl::unexpected(sent.error());
  const auto message = connected->receive(waiting);
  if (!message)
    return fail(message.error().fault,
                where + " did not confirm the key (" + message.error().what +
                    "): start rt_server pair again, and give --name if its ring has got '" + key.name + "'");
  const auto answer = decode_pairing_answer(*message);
  if (!answer) return fail(Fault::Malformed, where + " does not follow the protocol of a pairing");
  if (*answer == PairingAnswer::Taken)
    return fail(Fault::Unavailable,
                "the ring of " + where + " has a key named '" + key.name +
                    "' already: give another --name, or delete its line in the ring there");
  if (*answer == PairingAnswer::NotWritten)
    return fail(Fault::Unreadable, where + " cannot write its key ring: rt_server pair says there why");
  return {};
}

}  // namespace farshade
