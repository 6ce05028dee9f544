#include "stereo/net/sealed_stream.h"

#include <algorithm>

#include "stereo/base/check.h"
#include "stereo/net/explain.h"

namespace farshade {
namespace {

constexpr std::size_t kLength_bytes = 2, kRead_bytes = 65536;

tl::unexpected<Error> strange() {
  return fail(Fault::Malformed, "the other side does not follow the protocol");
}

}  // namespace

ContentHash hello_of(StreamPurpose purpose) {
  const std::string_view text =
      purpose == StreamPurpose::Pairing ? "farshade pairing" : "farshade scene fetch";
  ContentHash hash{};
  std::ranges::copy(text, hash.begin());
  return hash;
}

Expected<SealedStream> SealedStream::connect(TcpStream stream, StreamPurpose purpose, const SharedKey& key,
                                             const Waiting& waiting) {
  const Peer server = stream.peer();
  SealedStream connected(std::move(stream));
  const ClientHandshake handshake(key, hello_of(purpose));
  handshake.write_hello(connected.envelope_);
  connected.add_frame(connected.envelope_);
  if (auto sent = connected.flush(waiting); !sent) return tl::unexpected(sent.error());
  const auto frame = connected.receive_frame(waiting);
  if (!frame) return tl::unexpected(frame.error());
  const Decoded<ServerEnvelope> envelope = open_server_envelope(*frame);
  if (!envelope) return strange();
  if (const auto* refusal = std::get_if<OpenRefusal>(&*envelope)) {
    if (purpose == StreamPurpose::Pairing && refusal->reason == RefusalReason::UnknownKey)
      return fail(Fault::Mismatch, to_string(server) + " shows another code: it is mistyped, or too old");
    return fail(Fault::Mismatch, explain(*refusal, key, server).sentence());
  }
  const auto* accept = std::get_if<Accept>(&*envelope);
  const auto completed = accept != nullptr ? handshake.take(*accept, *frame) : std::nullopt;
  if (!completed || !std::holds_alternative<Welcome>(completed->answer)) return strange();
  connected.served_ = std::get<Welcome>(completed->answer);
  connected.key_ = id_of(key);
  const SessionKeys& keys = completed->keys;
  connected.sealer_.emplace(keys.session, keys.to_server, keys.sealing);
  connected.opener_.emplace(keys.to_client, keys.sealing);
  return connected;
}

Expected<SealedStream> SealedStream::admit(TcpStream stream, StreamPurpose purpose, const KeyRing& ring,
                                           const Welcome& served, const Waiting& waiting) {
  const Peer client = stream.peer();
  SealedStream connected(std::move(stream));
  const auto frame = connected.receive_frame(waiting);
  if (!frame) return tl::unexpected(frame.error());
  const Decoded<ClientEnvelope> envelope = open_client_envelope(*frame);
  if (!envelope) return strange();
  const auto refuse_openly = [&](RefusalReason reason, const HelloEcho& echo, const std::string& why) {
    encode(OpenRefusal{.reason = reason, .echo = echo}, connected.envelope_);
    connected.add_frame(connected.envelope_);
    static_cast<void>(connected.flush(waiting));
    return fail(Fault::Mismatch, why);
  };
  if (const auto* foreign = std::get_if<ForeignHello>(&*envelope))
    return refuse_openly(RefusalReason::VersionMismatch, foreign->echo,
                         "refused a client at " + to_string(client) + ": it speaks protocol version " +
                             std::to_string(foreign->version));
  const auto* hello = std::get_if<Hello>(&*envelope);
  if (hello == nullptr || hello->scene_hash != hello_of(purpose)) return strange();
  const auto key = ring.find(hello->key);
  if (key == ring.end() || !is_proved(*hello, *frame, key->second))
    return refuse_openly(RefusalReason::UnknownKey, echo_of(hello->client),
                         explain(hello->key, ring, client));
  const std::optional<Accepted> accepted = accept(*hello, *frame, key->second, served);
  if (!accepted) return strange();
  connected.add_frame(accepted->datagram);
  if (auto sent = connected.flush(waiting); !sent) return tl::unexpected(sent.error());
  connected.served_ = served;
  connected.key_ = key->first;
  connected.version_ = hello->version;
  connected.sealer_.emplace(accepted->keys.session, accepted->keys.to_client, accepted->keys.sealing,
                            hello->version);
  connected.opener_.emplace(accepted->keys.to_server, accepted->keys.sealing);
  return connected;
}

void SealedStream::add(std::span<const std::byte> message) {
  sealer_->seal(message, envelope_);
  add_frame(envelope_);
}

void SealedStream::add_frame(std::span<const std::byte> envelope) {
  const auto size = narrow<std::uint16_t>(envelope.size());
  outgoing_.push_back(static_cast<std::byte>(size & 0xff));
  outgoing_.push_back(static_cast<std::byte>(size >> 8));
  outgoing_.insert(outgoing_.end(), envelope.begin(), envelope.end());
}

Expected<void> SealedStream::flush(const Waiting& waiting) {
  Expected<void> written = stream_.write(outgoing_, waiting);
  outgoing_.clear();
  return written;
}

Expected<std::span<const std::byte>> SealedStream::receive_frame(const Waiting& waiting) {
  for (;;) {
    const std::span<const std::byte> rest = std::span(incoming_).subspan(begin_);
    if (rest.size() >= kLength_bytes) {
      const std::size_t size = std::to_integer<std::size_t>(rest[0]) | std::to_integer<std::size_t>(rest[1])
                                                                           << 8;
      if (size > kBaseDatagram_bytes) return strange();
      if (rest.size() >= kLength_bytes + size) {
        begin_ += kLength_bytes + size;
        return rest.subspan(kLength_bytes, size);
      }
    }
    incoming_.erase(incoming_.begin(), incoming_.begin() + static_cast<std::ptrdiff_t>(begin_));
    begin_ = 0;
    const std::size_t kept = incoming_.size();
    incoming_.resize(kept + kRead_bytes);
    const Expected<std::size_t> got = stream_.read_some(std::span(incoming_).subspan(kept), waiting);
    incoming_.resize(kept + got.value_or(0));
    if (!got) return tl::unexpected(got.error());
  }
}

Expected<std::span<const std::byte>> SealedStream::receive(const Waiting& waiting) {
  const auto frame = receive_frame(waiting);
  if (!frame) return tl::unexpected(frame.error());
  // A Sealed has the same layout in both directions.
  const Decoded<ServerEnvelope> envelope = open_server_envelope(*frame);
  const auto* sealed = envelope ? std::get_if<Sealed>(&*envelope) : nullptr;
  if (sealed == nullptr || sealed->version != version_ || sealed->counter != received_) return strange();
  const auto opened = opener_->open(*sealed, *frame, message_);
  if (!opened) return strange();
  ++received_;
  return *opened;
}

}  // namespace farshade
