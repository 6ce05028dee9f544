#include "rt_server/sessions/session.h"

#include <sodium.h>

#include "stereo/messages/timing.h"

namespace farshade {
namespace {

/// Share of the frame interval over which a frame's datagrams leave. With a larger share most masks are used
/// before they are complete. Room at 128 x 128, 25 ms each way: 0.75 gave 22.1 dB and 1.6 % unknown, 0.5
/// gives 22.9 dB and 0.04 %.
constexpr double kPacedShare = 0.5;

std::uint32_t random_gap() {
  return 1 + randombytes_uniform(2 * ClientSession::kBetweenGaps - 1);
}

}  // namespace

ClientSession::ClientSession(const SharedKey& key, const Peer& client, const PublicKey& hello,
                             const Accepted& accepted, Time now, const RateLimits& limits,
                             const Welcome& served)
    : name_(key.name),
      key_(id_of(key)),
      id_(accepted.keys.session),
      version_(accepted.keys.version),
      hello_(hello),
      accept_(accepted.datagram),
      opener_(accepted.keys.to_server, accepted.keys.sealing),
      sealer_(id_, accepted.keys.to_client, accepted.keys.sealing, version_),
      until_gap_(random_gap()),
      began_(now),
      last_received_(now),
      last_sent_(now),
      path_(client, limits),
      requests_(served.most_pixels, served.answers) {}

Decoded<ReceivedMessage> ClientSession::receive(const Peer& from, const Sealed& sealed,
                                                std::span<const std::byte> datagram, Time now,
                                                std::vector<std::byte>& reply, std::size_t room) {
  if (sealed.version != version_) return refuse(WireRefusal::Version);
  const bool newest = !opener_.window().newest() || sealed.counter > *opener_.window().newest();
  const Decoded<std::span<const std::byte>> opened = opener_.open(sealed, datagram, message_);
  if (!opened) return refuse(opened.error());
  last_received_ = now;
  confirmed_ = true;
  sealer_.renew(now);
  const Decoded<ClientMessage> message = decode_client(*opened, version_);
  if (!message) return refuse(message.error());
  if (std::holds_alternative<Leave>(*message)) return ReceivedMessage::Left;
  if (const auto* slice = std::get_if<PlaneSlice>(&*message))
    return requests_.receive(*slice, *opened, now, room);
  if (const auto* slice = std::get_if<AskSlice>(&*message))
    return requests_.receive(*slice, *opened, now, room);
  return receive_request(from, std::get<RequestMessage>(*message), newest, now, reply);
}

ReceivedMessage ClientSession::receive_request(const Peer& from, const RequestMessage& message, bool newest,
                                               Time now, std::vector<std::byte>& reply) {
  if (const auto token = path_.update_address(from, newest, message.probe_echo))
    path_.rate.sent_elsewhere(seal_probe(*token, reply), now);
  if (from == client() && now - last_sent_ > kKeepaliveInterval) {
    // A new token: the one that proves the candidate's address must not be sent to another address.
    const std::uint64_t counter = seal_probe(random_token(), reply);
    record_sent(counter, reply.size(), now);
  }
  path_.rate.take(message.arrivals, now);
  path_.mtu.take(message.arrivals, now);
  if (from == client() && reply.empty()) probe_path(now, reply);
  return requests_.receive(message.request, now);
}

std::uint64_t ClientSession::seal_probe(std::uint64_t token, std::vector<std::byte>& probe) {
  encode(Probe{token}, message_, version_);
  return sealer_.seal(message_, probe);
}

/// Makes a datagram whose arrival shows that the path carries its size. Its loss says nothing about the rate.
void ClientSession::probe_path(Time now, std::vector<std::byte>& probe) {
  const std::optional<std::size_t> size = path_.mtu.next_probe(now);
  if (!size) return;
  encode(PathProbe{std::span(PathProbe::kZeros).first(*size - kSealing_bytes - 1)}, message_, version_);
  const std::uint64_t counter = sealer_.seal(message_, probe);
  path_.rate.sent_elsewhere(counter, now);
  path_.mtu.probed(counter, now);
}

void ClientSession::record_sent(std::uint64_t counter, std::size_t bytes, Time now) {
  path_.rate.sent(counter, bytes, now);
  path_.mtu.sent(counter, bytes);
  last_sent_ = now;
}

/// The path has become so much slower that the frame in the outbox is to be overtaken.
bool ClientSession::is_late() const {
  return outbox_.ends_at(path_.rate.sending_bytes_per_second()) > planned_end_ + kMostLate;
}

std::optional<Time> ClientSession::ready_at() const {
  const std::optional<Time> at = requests_.ready_at();
  if (!at || (!outbox_.empty() && !is_late())) return std::nullopt;
  return std::max(outbox_.drained_at(), *at);
}

Job ClientSession::take_job() {
  Job job = requests_.take();
  job.session = id_;
  job.version = version_;
  job.key = key_;
  job.bytes_per_second = static_cast<std::uint32_t>(path_.rate.bytes_per_second());
  job.view_scale = job_scale_ = quality_.view_scale();
  job.most_message_bytes = path_.mtu.bytes() - kSealing_bytes;
  job_is_cube_mask_ = job.request.answer.kind == Answer::CubeMask;
  return job;
}

ClientSession::PutFrame ClientSession::put(std::vector<std::vector<std::byte>> messages, Time now,
                                           JobEnd end) {
  const Duration interval = requests_.interval();
  const auto spread =
      job_is_cube_mask_ ? Duration::zero() : std::chrono::duration_cast<Duration>(interval * kPacedShare);
  const double rate = path_.rate.bytes_per_second();
  std::size_t bytes = 0;
  for (const std::vector<std::byte>& message : messages) bytes += message.size() + kSealing_bytes;
  const PutFrame frame{
      .is_held_back = path_.is_limited() && static_cast<double>(bytes) > rate * seconds_of(interval),
      .overtakes = !outbox_.empty()};
  outbox_.drop();
  outbox_.put(std::move(messages), now, spread);
  planned_end_ = outbox_.ends_at(path_.rate.sending_bytes_per_second());
  if (end == JobEnd::GivenUp)
    quality_.was_too_costly(now);
  else if (!job_is_cube_mask_)
    quality_.packed(bytes, job_scale_, rate, interval, now);
  return frame;
}

void ClientSession::seal_goodbye(EndReason reason, std::vector<std::byte>& datagram) {
  outbox_.drop();
  encode(Goodbye{reason}, message_, version_);
  sealer_.seal(message_, datagram);
}

void ClientSession::seal_due(Time now, std::vector<std::byte>& datagram) {
  sealer_.renew(now);
  const std::uint64_t counter = sealer_.seal(outbox_.take(path_.rate.sending_bytes_per_second()), datagram);
  record_sent(counter, datagram.size(), now);
  if (--until_gap_ > 0) return;
  path_.rate.skipped(sealer_.skip(), now);
  until_gap_ = random_gap();
}

}  // namespace farshade
