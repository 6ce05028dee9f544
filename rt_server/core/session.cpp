#include "rt_server/core/session.h"

#include <sodium.h>

#include <algorithm>
#include <utility>

namespace farshade {
namespace {

/// Of the frame interval. More, and every mask is shown half arrived: room at 128 x 128, 25 ms each way, 0.75
/// gave 22.1 dB and 1.6 % unknown, 0.5 gives 22.9 dB and 0.04 %.
constexpr double kPacedShare = 0.5;
/// Clients that ask less often than this get their slices within it.
constexpr Duration kLongestInterval = std::chrono::milliseconds(50);

/// A client that asks and to which nothing has been sent for so long is told that its session lives: a server
/// with much to trace is not taken for one that was restarted.
constexpr Duration kSignOfLife = std::chrono::milliseconds(100);

std::uint64_t random_token() {
  std::uint64_t token = 0;
  while (token == 0) randombytes_buf(&token, sizeof token);
  return token;
}

}  // namespace

ClientSession::ClientSession(std::string name, const Peer& client, const PublicKey& hello,
                             const Accepted& accepted, Time now, const RateLimits& limits,
                             const Welcome& served)
    : name_(std::move(name)),
      id_(accepted.keys.session),
      hello_(hello),
      accept_(accepted.datagram),
      opener_(accepted.keys.to_server, accepted.keys.sealing),
      sealer_(accepted.keys.session, accepted.keys.to_client, accepted.keys.sealing),
      limits_(limits),
      most_pixels_(served.most_pixels),
      answers_(served.answers),
      client_(client),
      heard_(now),
      told_(now),
      rate_(limits) {}

Decoded<ReceivedMessage> ClientSession::take(const Peer& from, const Sealed& sealed,
                                             std::span<const std::byte> datagram, Time now,
                                             std::vector<std::byte>& probe) {
  const bool newest = !opener_.window().newest() || sealed.counter > *opener_.window().newest();
  const Decoded<std::span<const std::byte>> opened = opener_.open(sealed, datagram, message_);
  if (!opened) return refuse(opened.error());
  heard_ = now;
  confirmed_ = true;
  const Decoded<ClientMessage> message = decode_client(*opened);
  if (!message) return refuse(message.error());
  if (const auto* slice = std::get_if<PlaneSlice>(&*message)) return take_positions(*slice, *opened, now);
  const auto& request = std::get<RequestMessage>(*message);
  follow(from, newest, request.probe_echo, probe);
  if (from == client_ && now - told_ > kSignOfLife) give_sign_of_life(probe);
  return take(request, now);
}

/// An address is believed once who is there has said the token that was sent there: a datagram caught on its
/// way and sent on from elsewhere moves nothing.
void ClientSession::follow(const Peer& from, bool newest, std::uint64_t probe_echo,
                           std::vector<std::byte>& probe) {
  if (from == client_) {
    if (newest) candidate_.reset();
    return;
  }
  if (from == candidate_ && probe_echo == probe_token_) {
    client_ = from;
    candidate_.reset();
    return;
  }
  if (!newest) return;
  if (from != candidate_) {
    candidate_ = from;
    probe_token_ = random_token();
  }
  encode(Probe{probe_token_}, message_);
  rate_.sent(sealer_.seal(message_, probe), probe.size(), heard_);
}

/// With a token of its own: one that proves a new address must not be told to an old one.
void ClientSession::give_sign_of_life(std::vector<std::byte>& probe) {
  encode(Probe{random_token()}, message_);
  rate_.sent(sealer_.seal(message_, probe), probe.size(), heard_);
  told_ = heard_;
}

ReceivedMessage ClientSession::take(const RequestMessage& message, Time now) {
  rate_.heard(message.arrivals, now);
  merge(lights_, message.request.lights);
  const FrameId frame = message.request.frame;
  if (newest_ && !is_newer(frame, *newest_)) return ReceivedMessage::Outdated;
  learn_interval(message.request, now);
  newest_ = frame;
  for (const View& view : message.request.views)
    if (view.size.pixels() > most_pixels_) return ReceivedMessage::TooLarge;
  const Answer answer = message.request.wanted.answer;
  if ((answers_ & set_of(answer)) == 0) return ReceivedMessage::Unanswered;
  // A renderer draws two eyes of one size.
  const StereoView& views = message.request.views;
  if (is_drawn(answer) && views[0].size != views[1].size) return ReceivedMessage::Unanswered;
  const bool superseded = waiting_.has_value();
  if (superseded) ++superseded_;
  waiting_ = Job{.session = id_, .request = message.request, .arrived = now};
  waiting_->request.lights = lights_;
  positions_bytes_ = 0;
  position_heard_ = now;
  return superseded ? ReceivedMessage::Superseded : ReceivedMessage::News;
}

/// They are opened when their turn comes: until then they take no more memory than they took on the wire.
ReceivedMessage ClientSession::take_positions(const PlaneSlice& slice, std::span<const std::byte> message,
                                              Time now) {
  const bool fits = waiting_ && waiting_->request.frame == slice.frame &&
                    waiting_->positions.size() < waiting_->request.wanted.slices &&
                    positions_bytes_ + message.size() <= kMostPositions_bytes;
  if (!fits) return ReceivedMessage::Stray;
  waiting_->positions.emplace_back(message.begin(), message.end());
  positions_bytes_ += message.size();
  position_heard_ = now;
  return ReceivedMessage::Positions;
}

/// In virtual time a client asks less often than its display would; in real time requests may bunch up on the
/// way.
void ClientSession::learn_interval(const FrameRequest& request, Time now) {
  if (newest_) {
    const Duration seen = std::min(request.display_time - newest_display_, now - newest_arrived_);
    interval_ += (std::clamp(seen, Duration::zero(), kLongestInterval) - interval_) / 8;
  }
  newest_display_ = request.display_time;
  newest_arrived_ = now;
}

std::optional<Time> ClientSession::ready_at() const {
  if (!waiting_ || !outbox_.empty()) return std::nullopt;
  const bool whole = waiting_->positions.size() >= waiting_->request.wanted.slices;
  return whole ? outbox_.drained_at() : std::max(outbox_.drained_at(), position_heard_ + kPositionsLull);
}

Job ClientSession::take_job() {
  Job job = std::move(*std::exchange(waiting_, std::nullopt));
  job.superseded = superseded_;
  job.bytes_per_second = static_cast<std::uint32_t>(rate_.bytes_per_second());
  job.view_scale = quality_.view_scale();
  job_scale_ = job.view_scale;
  return job;
}

void ClientSession::put(std::span<const std::vector<std::byte>> messages, Time now) {
  const auto spread = std::chrono::duration_cast<Duration>(interval_ * kPacedShare);
  const double rate = rate_.bytes_per_second();
  std::size_t bytes = 0;
  for (const std::vector<std::byte>& message : messages) bytes += message.size() + kSealing_bytes;
  if (rate >= limits_.most && static_cast<double>(bytes) > rate * seconds_of(interval_)) ++held_back_;
  outbox_.put(messages, now, spread, rate);
  quality_.packed(bytes, job_scale_, rate, interval_, now);
}

void ClientSession::seal_due(Time now, std::vector<std::byte>& datagram) {
  told_ = now;
  const std::uint64_t counter = sealer_.seal(outbox_.take(), datagram);
  rate_.sent(counter, datagram.size(), now);
}

}  // namespace farshade
