#include "rt_server/sessions/session.h"

#include <sodium.h>

#include <algorithm>
#include <utility>

#include "stereo/base/check.h"
#include "stereo/frame/tiles.h"

namespace farshade {
namespace {

/// Share of the frame interval over which a frame's datagrams leave. With a larger share most masks are used
/// before they are complete. Room at 128 x 128, 25 ms each way: 0.75 gave 22.1 dB and 1.6 % unknown, 0.5
/// gives 22.9 dB and 0.04 %.
constexpr double kPacedShare = 0.5;
/// Upper limit of the interval between two requests.
constexpr Duration kLongestInterval = std::chrono::milliseconds(50);

std::uint64_t random_token() {
  std::uint64_t token = 0;
  while (token == 0) randombytes_buf(&token, sizeof token);
  return token;
}

std::uint32_t random_gap() {
  return 1 + randombytes_uniform(2 * ClientSession::kBetweenGaps - 1);
}

/// The tiles that the messages of a request have, if each comes once: a position has three coordinates.
std::size_t tiles_of(const FrameRequest& request) {
  std::size_t tiles = 0;
  for (const View& view : request.views) tiles += TileGrid{view.size}.count();
  return request.answer.kind == Answer::MasksOfPositions ? 3 * tiles : tiles;
}

bool is_asked_of_clients(const PlaneSlice& slice) {
  return slice.kind >= PlaneKind::PositionX;
}
bool is_asked_of_clients(const AskSlice&) {
  return true;
}

}  // namespace

void Outbox::put(std::vector<std::vector<std::byte>> messages, Time now, Duration spread) {
  check(empty(), "an outbox takes a frame only when it is empty");
  if (messages.empty()) return;
  messages_ = std::move(messages);
  taken_ = 0;
  for (const std::vector<std::byte>& message : messages_) {
    bytes_ += message.capacity() + kMessage_bytes;
    bytes_left_ += message.size();
  }
  share_ = spread / static_cast<Duration::rep>(messages_.size());
  next_due_ = std::max(now, next_due_);
}

std::optional<Time> Outbox::due() const {
  return empty() ? std::nullopt : std::optional(next_due_);
}

std::vector<std::byte> Outbox::take(double bytes_per_second) {
  check(!empty(), "a message is taken only if there is one");
  check(bytes_per_second > 0, "the rate of a path is positive");
  std::vector<std::byte> message = std::move(messages_[taken_++]);
  bytes_ -= message.capacity() + kMessage_bytes;
  bytes_left_ -= message.size();
  if (empty()) {
    messages_ = {};
    taken_ = 0;
  }
  next_due_ +=
      std::max(share_, duration_from_ms(1e3 * static_cast<double>(message.size()) / bytes_per_second));
  return message;
}

Time Outbox::ends_at(double bytes_per_second) const {
  check(bytes_per_second > 0, "the rate of a path is positive");
  return next_due_ + std::max(share_ * static_cast<Duration::rep>(messages_.size() - taken_),
                              duration_from_ms(1e3 * static_cast<double>(bytes_left_) / bytes_per_second));
}

void Outbox::drop() {
  messages_ = {};
  taken_ = bytes_ = bytes_left_ = 0;
}

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
      limits_(limits),
      most_pixels_(served.most_pixels),
      answers_(served.answers),
      client_(client),
      began_(now),
      last_received_(now),
      last_sent_(now),
      rate_(limits),
      until_gap_(random_gap()) {}

Decoded<ReceivedMessage> ClientSession::receive(const Peer& from, const Sealed& sealed,
                                                std::span<const std::byte> datagram, Time now,
                                                std::vector<std::byte>& reply, std::size_t room) {
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
    return receive_part(Answer::MasksOfPositions, *slice, *opened, now, room);
  if (const auto* slice = std::get_if<AskSlice>(&*message))
    return receive_part(Answer::Masks, *slice, *opened, now, room);
  const auto& request = std::get<RequestMessage>(*message);
  update_address(from, newest, request.probe_echo, reply);
  if (from == client_ && now - last_sent_ > kKeepaliveInterval) {
    // A new token: the one that proves the candidate's address must not be sent to another address.
    const std::uint64_t counter = seal_probe(random_token(), reply);
    record_sent(counter, reply.size(), now);
  }
  const ReceivedMessage received = receive(request, now);
  if (from == client_ && reply.empty()) probe_path(now, reply);
  return received;
}

void ClientSession::limit(const RateLimits& limits) {
  limits_ = limits;
  rate_.limit(limits);
}

/// Frames follow the client to another address only after a datagram from there has returned the token that
/// was sent there. An attacker who intercepts a datagram and sends it from elsewhere cannot read the token.
void ClientSession::update_address(const Peer& from, bool newest, std::uint64_t probe_echo,
                                   std::vector<std::byte>& probe) {
  if (from == client_) {
    if (newest) candidate_.reset();
    return;
  }
  if (from == candidate_ && probe_echo == probe_token_) {
    client_ = from;
    candidate_.reset();
    const bool got_false_report = rate_.got_false_report();
    rate_ = RateControl(limits_);  // nothing is known about the new path, but about the client
    if (got_false_report) rate_.distrust();
    path_mtu_ = PathMtu();
    return;
  }
  if (!newest) return;
  if (from != candidate_) {
    candidate_ = from;
    probe_token_ = random_token();
  }
  rate_.sent_elsewhere(seal_probe(probe_token_, probe), last_received_);
}

std::uint64_t ClientSession::seal_probe(std::uint64_t token, std::vector<std::byte>& probe) {
  encode(Probe{token}, message_, version_);
  return sealer_.seal(message_, probe);
}

/// Makes a datagram whose arrival shows that the path carries its size. Its loss says nothing about the rate.
void ClientSession::probe_path(Time now, std::vector<std::byte>& probe) {
  const std::optional<std::size_t> size = path_mtu_.next_probe(now);
  if (!size) return;
  encode(PathProbe{std::span(PathProbe::kZeros).first(*size - kSealing_bytes - 1)}, message_, version_);
  const std::uint64_t counter = sealer_.seal(message_, probe);
  rate_.sent_elsewhere(counter, now);
  path_mtu_.probed(counter, now);
}

void ClientSession::record_sent(std::uint64_t counter, std::size_t bytes, Time now) {
  rate_.sent(counter, bytes, now);
  path_mtu_.sent(counter, bytes);
  last_sent_ = now;
}

std::optional<ReceivedMessage> ClientSession::refuse_request(const FrameRequest& request) const {
  for (const View& view : request.views)
    if (view.size.pixels() > most_pixels_) return ReceivedMessage::TooLarge;
  const Answer answer = request.answer.kind;
  if ((answers_ & set_of(answer)) == 0) return ReceivedMessage::Unanswered;
  // A renderer draws two eyes of one size.
  if (is_drawn(answer) && request.views[0].size != request.views[1].size) return ReceivedMessage::Unanswered;
  return std::nullopt;
}

std::optional<Job>& ClientSession::waiting_for(const FrameRequest& request) {
  return request.answer.kind == Answer::CubeMask ? waiting_cube_mask_[pair_of(request.frame)] : waiting_;
}

ReceivedMessage ClientSession::receive(const RequestMessage& message, Time now) {
  rate_.take(message.arrivals, now);
  path_mtu_.take(message.arrivals, now);
  merge(lights_, message.request.lights);
  const FrameId frame = message.request.frame;
  const Answer answer = message.request.answer.kind;
  const bool is_cube_mask = answer == Answer::CubeMask;
  std::optional<FrameId>& newest = is_cube_mask ? newest_cube_mask_[pair_of(frame)] : newest_;
  if (newest && !is_newer(frame, *newest)) return ReceivedMessage::Outdated;
  // A request that is refused leaves nothing behind that later ones are compared with.
  if (const std::optional<ReceivedMessage> why = refuse_request(message.request)) return *why;
  if (!is_cube_mask) update_interval(message.request, now);
  newest = frame;
  std::optional<Job>& waiting = waiting_for(message.request);
  const bool superseded = waiting.has_value();
  if (superseded) ++superseded_;
  waiting = Job{.session = id_, .key = key_, .version = version_, .request = message.request, .arrived = now};
  waiting->request.lights = lights_;
  if (!is_cube_mask) {
    requested_answer_ = answer;
    parts_bytes_ = 0;
    tiles_left_ = tiles_of(message.request);
    part_arrived_ = now;
  }
  return superseded ? ReceivedMessage::Superseded : ReceivedMessage::NewRequest;
}

/// Stores the compressed message. It is unpacked when the request is answered, so that waiting messages take
/// no more memory than they took on the wire.
template <class TileSlice>
ReceivedMessage ClientSession::receive_part(Answer of, const TileSlice& slice,
                                            std::span<const std::byte> message, Time now, std::size_t room) {
  const bool fits = waiting_ && waiting_->request.frame == slice.frame &&
                    waiting_->request.answer.kind == of &&
                    waiting_->parts.size() < waiting_->request.answer.slices &&
                    parts_bytes_ + message.size() <= kMostParts_bytes &&
                    slice.size == waiting_->request.views[index_of(slice.eye)].size &&
                    slice.tile_count <= tiles_left_ && is_asked_of_clients(slice);
  if (!fits) return ReceivedMessage::Stray;
  if (message.size() + kMessage_bytes > room) return ReceivedMessage::OverMemory;
  tiles_left_ -= slice.tile_count;
  waiting_->parts.emplace_back(message.begin(), message.end());
  parts_bytes_ += message.size();
  part_arrived_ = now;
  return ReceivedMessage::Part;
}

/// Uses the shorter of two measures. In virtual time a client sends requests less often than its display
/// times say. In real time several requests may arrive at once after a delay.
void ClientSession::update_interval(const FrameRequest& request, Time now) {
  if (newest_) {
    const Duration measured = std::min(request.display_time - newest_display_, now - newest_arrived_);
    interval_ += (std::clamp(measured, Duration::zero(), kLongestInterval) - interval_) / 8;
  }
  newest_display_ = request.display_time;
  newest_arrived_ = now;
}

/// All parts of the waiting request have come.
bool ClientSession::is_complete() const {
  return waiting_ && waiting_->parts.size() >= waiting_->request.answer.slices;
}

/// The pair whose request has waited longest.
std::optional<std::size_t> ClientSession::oldest_cube_mask() const {
  std::optional<std::size_t> oldest;
  for (std::size_t pair = 0; pair < kCubeMaskPairs; ++pair)
    if (waiting_cube_mask_[pair] && (!oldest || is_newer(waiting_cube_mask_[*oldest]->request.frame,
                                                         waiting_cube_mask_[pair]->request.frame)))
      oldest = pair;
  return oldest;
}

/// The path has become so much slower that the frame in the outbox is to be overtaken.
bool ClientSession::is_late() const {
  return outbox_.ends_at(rate_.sending_bytes_per_second()) > planned_end_ + kMostLate;
}

std::optional<Time> ClientSession::ready_at() const {
  const bool any_cube_mask = oldest_cube_mask().has_value();
  if ((!outbox_.empty() && !is_late()) || (!waiting_ && !any_cube_mask)) return std::nullopt;
  return any_cube_mask || is_complete() ? outbox_.drained_at()
                                        : std::max(outbox_.drained_at(), part_arrived_ + kPartsTimeout);
}

/// A request for the cube mask is taken before another one only if that is not complete yet, or if enough
/// others have overtaken it.
Job ClientSession::take_job() {
  const std::optional<std::size_t> pair = oldest_cube_mask();
  job_is_cube_mask_ = pair && (!is_complete() || overtaken_ >= kMostOvertaking);
  std::optional<Job>& waiting = job_is_cube_mask_ ? waiting_cube_mask_[*pair] : waiting_;
  Job job = std::move(*std::exchange(waiting, std::nullopt));
  overtaken_ = pair && !job_is_cube_mask_ ? overtaken_ + 1 : 0;
  job.superseded = superseded_;
  job.bytes_per_second = static_cast<std::uint32_t>(rate_.bytes_per_second());
  job.view_scale = quality_.view_scale();
  job.most_message_bytes = path_mtu_.bytes() - kSealing_bytes;
  job_scale_ = job.view_scale;
  return job;
}

void ClientSession::put(std::vector<std::vector<std::byte>> messages, Time now, JobEnd end) {
  const auto spread =
      job_is_cube_mask_ ? Duration::zero() : std::chrono::duration_cast<Duration>(interval_ * kPacedShare);
  const double rate = rate_.bytes_per_second();
  std::size_t bytes = 0;
  for (const std::vector<std::byte>& message : messages) bytes += message.size() + kSealing_bytes;
  if (rate >= limits_.most && static_cast<double>(bytes) > rate * seconds_of(interval_)) ++held_back_;
  if (!outbox_.empty()) ++frames_overtaken_;
  outbox_.drop();
  outbox_.put(std::move(messages), now, spread);
  planned_end_ = outbox_.ends_at(rate_.sending_bytes_per_second());
  if (end == JobEnd::GivenUp)
    quality_.was_too_costly(now);
  else if (!job_is_cube_mask_)
    quality_.packed(bytes, job_scale_, rate, interval_, now);
}

void ClientSession::seal_goodbye(EndReason reason, std::vector<std::byte>& datagram) {
  outbox_.drop();
  encode(Goodbye{reason}, message_, version_);
  sealer_.seal(message_, datagram);
}

void ClientSession::seal_due(Time now, std::vector<std::byte>& datagram) {
  sealer_.renew(now);
  const std::uint64_t counter = sealer_.seal(outbox_.take(rate_.sending_bytes_per_second()), datagram);
  record_sent(counter, datagram.size(), now);
  if (--until_gap_ > 0) return;
  rate_.skipped(sealer_.skip(), now);
  until_gap_ = random_gap();
}

}  // namespace farshade
