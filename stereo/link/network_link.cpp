#include "stereo/link/network_link.h"

#include <algorithm>

#include "stereo/base/check.h"
#include "stereo/messages/timing.h"
#include "stereo/net/explain.h"

namespace farshade {
namespace {

/// The largest rate of positions: 32 datagrams of 1,200 bytes every 200 us are 1.5 Gbit/s.
constexpr std::size_t kBurst = 32;
constexpr Duration kBurstPause = std::chrono::microseconds(200);
/// "video, difference".
std::string names_of(AnswerSet answers) {
  constexpr std::array<std::string_view, kAnswers> names{"masks", "masks of positions", "G-buffers",
                                                         "video", "difference",         "cube masks"};
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    if ((answers >> i & 1u) != 0) text.append(text.empty() ? "" : ", ").append(names[i]);
  return text;
}

}  // namespace

NetworkLink::Channel::Channel(const SessionKeys& keys, Time now)
    : id(keys.session),
      sealer(keys.session, keys.to_server, keys.sealing),
      opener(keys.to_client, keys.sealing),
      last_received(now) {}

NetworkLink::NetworkLink(DatagramPort& port, const Clock& clock, const LinkTarget& target, std::size_t frames)
    : port_(port), clock_(clock), target_(target), receiver_(frames, target.mask) {}

NetworkLink::~NetworkLink() {
  if (!channel_) return;
  encode(Leave{}, message_);
  for (int i = 0; i < kGoodbyes; ++i) {
    if (i > 0) wait_out(kBetweenGoodbyes);  // what loses one may lose the next one, too
    channel_->sealer.seal(message_, outgoing_);
    send_outgoing();
  }
}

/// Waits, whatever comes.
void NetworkLink::wait_out(Duration span) {
  std::array<std::byte, kMaxDatagram_bytes> ignored;
  const Time until = clock_.now() + span;
  for (Duration left = span; left > Duration::zero(); left = until - clock_.now())
    static_cast<void>(port_.receive(ignored, left));
}

void NetworkLink::send_outgoing() {
  traffic_.up += outgoing_.size();
  port_.send(target_.server, outgoing_);
}

void NetworkLink::say_hello() {
  if (last_hello_ && clock_.now() - *last_hello_ < kHelloInterval) return;
  last_hello_ = clock_.now();
  if (!first_hello_) first_hello_ = last_hello_;
  if (!handshake_) handshake_.emplace(target_.key, target_.scene_hash);
  handshake_->write_hello(outgoing_);
  send_outgoing();
}

/// Says hello if there is no session, or if the server is silent.
void NetworkLink::keep_session() {
  if (refused_) return;
  const bool silent = channel_ && channel_->unanswered >= kLeastUnanswered &&
                      clock_.now() - channel_->last_received > kServerSilence;
  if (!channel_ || handshake_ || silent) say_hello();
}

Expected<void> NetworkLink::connect(Duration patience) {
  const Time until = clock_.now() + patience;
  while (!channel_ && !refused_ && clock_.now() < until) {
    keep_session();
    receive_one(std::min(kHelloInterval, until - clock_.now()));
  }
  if (refused_) return tl::unexpected(*refused_);
  if (channel_) return {};
  if (unproved_refusal_) return fail(Fault::Mismatch, *unproved_refusal_);
  if (busy_server_) return fail(Fault::Unavailable, *busy_server_);
  return fail(Fault::Missing, "no server answers at " + to_string(target_.server));
}

void NetworkLink::request(const FrameRequest& request, Time requested_at, const RequestParts& parts) {
  keep_session();
  if (!channel_) return;
  send_request(receiver_.ask(request, requested_at, clock_.now(), parts.reprojected));
  send_following(parts.messages);
}

/// Sends in bursts that fit the buffer of a socket, with pauses in which its reader can empty it.
void NetworkLink::send_following(std::span<const std::vector<std::byte>> messages) {
  for (std::size_t i = 0; i < messages.size(); ++i) {
    if (i > 0 && i % kBurst == 0) listen(kBurstPause);
    if (!channel_) return;
    channel_->sealer.seal(messages[i], outgoing_);
    send_outgoing();
  }
}

void NetworkLink::send_request(const FrameRequest& request) {
  if (listener_.sent) listener_.sent(request);
  seal_request(request);
  if (request.answer.kind != Answer::CubeMask) channel_->newest_sent = request.frame;
  if (channel_->unanswered++ == 0) channel_->requested = clock_.now();
}

void NetworkLink::seal_request(const FrameRequest& request) {
  RequestMessage message{
      .request = request, .probe_echo = channel_->probe_echo, .arrivals = channel_->arrivals.report()};
  const RequestRecord* const newest = receiver_.newest_known();
  // When a request is sent again, its own answer may have come.
  if (newest != nullptr && request.answer.kind != Answer::CubeMask &&
      is_newer(request.frame, newest->request.frame))
    message.newest_received = newest->request.frame;
  encode(message, message_);
  channel_->sealer.renew(clock_.now());
  channel_->sealer.seal(message_, outgoing_);
  send_outgoing();
}

void NetworkLink::keep_alive() {
  if (!channel_ || !channel_->newest_sent) return;
  const RequestRecord* const record = receiver_.find(*channel_->newest_sent);
  if (record == nullptr) return;
  FrameRequest again = record->request;
  // The server may have missed any change, and merges those that it has.
  again.lights = since(again.lights, kFirstLightSet, RequestMessage::kMostLightChanges);
  seal_request(again);
}

bool NetworkLink::receive_one(Duration wait) {
  const std::optional<Datagram> datagram = port_.receive(incoming_, wait);
  if (!datagram) return false;
  traffic_.down += datagram->bytes.size();
  const Stopwatch watch;
  if (const Decoded<void> taken = take_datagram(*datagram); !taken) undecodable_.count(taken.error());
  busy_ += watch.elapsed();
  return true;
}

Decoded<void> NetworkLink::take_datagram(const Datagram& datagram) {
  const Decoded<ServerEnvelope> envelope = open_server_envelope(datagram.bytes);
  if (!envelope) return refuse(envelope.error());
  const auto version = std::visit([](const auto& any) { return any.version; }, *envelope);
  if (version != kProtocolVersion && !std::holds_alternative<OpenRefusal>(*envelope))
    return refuse(WireRefusal::Version);
  if (const auto* sealed = std::get_if<Sealed>(&*envelope)) return take_sealed(*sealed, datagram);
  if (const auto* lost = std::get_if<NoSession>(&*envelope)) {
    const bool silent = channel_ && clock_.now() - channel_->last_received > kServerSilenceAfterNoSession;
    if (silent && lost->session == channel_->id) say_hello();
    return {};
  }
  if (!handshake_) return {};
  if (const auto* retry = std::get_if<Retry>(&*envelope)) {
    if (!handshake_->take(*retry)) return {};
    last_hello_.reset();
    say_hello();
  } else if (const auto* accept = std::get_if<Accept>(&*envelope)) {
    take_accept(*accept, datagram.bytes);
  } else if (const auto* refusal = std::get_if<OpenRefusal>(&*envelope)) {
    take_refusal(*refusal);
  }
  return {};
}

void NetworkLink::take_refusal(const OpenRefusal& refusal) {
  if (refusal.echo != handshake_->echo()) return;
  if (!unproved_refusal_) unproved_refusal_ = explain(refusal, target_.key, target_.server).sentence();
}

/// The session is over. A server that ended may have been started anew, so the client greets it at once.
void NetworkLink::take(const Goodbye& goodbye, Time) {
  channel_.reset();
  goodbye_ = explain(goodbye, target_.key, target_.server).sentence();
  last_hello_.reset();
  first_hello_.reset();
  if (goodbye.reason == EndReason::Revoked || goodbye.reason == EndReason::Expired)
    refused_ = Error{Fault::Mismatch, *goodbye_};
  else
    say_hello();
}

void NetworkLink::take_accept(const Accept& accept, std::span<const std::byte> datagram) {
  const std::optional<ClientHandshake::Completed> completed = handshake_->take(accept, datagram);
  if (!completed) return;
  handshake_.reset();
  unproved_refusal_.reset();
  if (const auto* refusal = std::get_if<Refusal>(&completed->answer)) {
    const std::string why = explain(*refusal, target_.scene_hash).sentence();
    if (refusal->reason == RefusalReason::Busy)
      busy_server_ = why;
    else
      refused_ = Error{Fault::Mismatch, why};
    return;
  }
  const auto& welcome = std::get<Welcome>(completed->answer);
  const std::string server = "the server at " + to_string(target_.server);
  if (welcome.scene_hash != target_.scene_hash) {
    refused_ = Error{
        Fault::Mismatch,
        server + " serves another scene: start the client again without --scene, so that it fetches it"};
    return;
  }
  if (welcome.light_count != target_.mask.lights) {
    refused_ = Error{Fault::Mismatch, server + " has masks of " + std::to_string(welcome.light_count) +
                                          " lights, this client of " + std::to_string(target_.mask.lights) +
                                          ": start both with the same --plan"};
    return;
  }
  if ((target_.answers & ~welcome.answers) != 0) {
    refused_ = Error{Fault::Unsupported,
                     server + " does not give what this mode needs (" + names_of(target_.answers) +
                         "): it draws no pictures, or was built without video. Use --mode hybrid"};
    return;
  }
  channel_.emplace(completed->keys, clock_.now());
  goodbye_.reset();
  receiver_.begin(welcome);
  if (listener_.received) {
    encode(ServerMessage(welcome), message_);
    listener_.received(message_, clock_.now());
  }
  ++sessions_;
}

Decoded<void> NetworkLink::take_sealed(const Sealed& sealed, const Datagram& datagram) {
  if (!channel_ || sealed.session != channel_->id) return refuse(WireRefusal::UnknownSession);
  const Decoded<std::span<const std::byte>> opened = channel_->opener.open(sealed, datagram.bytes, message_);
  if (!opened) return refuse(opened.error());
  channel_->arrivals.add(sealed.counter, datagram.arrived);
  channel_->last_received = clock_.now();
  channel_->unanswered = 0;
  handshake_.reset();  // the session is alive, so no new one is needed
  const Decoded<ServerMessage> message = decode_server(*opened);
  if (!message) return refuse(message.error());
  if (listener_.received && !std::holds_alternative<Goodbye>(*message))
    listener_.received(*opened, datagram.arrived);
  std::visit([&](const auto& any) { take(any, datagram.arrived); }, *message);
  return {};
}

void NetworkLink::poll() {
  const Time begun = clock_.now();
  const Duration since = begun - polled_.value_or(begun);
  const Time until = begun + std::clamp(since / kPollingPart, kMostPolling, kLongestPolling);
  while (receive_one(Duration::zero())) {
    if (clock_.now() < until) continue;
    ++cut_short_;
    break;
  }
  polled_ = clock_.now();
}

void NetworkLink::listen(Duration span) {
  const Time until = clock_.now() + span;
  poll();
  for (Time now = clock_.now(); now < until; now = clock_.now()) receive_one(until - now);
}

bool NetworkLink::wait_for(FrameId frame, Duration patience) {
  const Time until = clock_.now() + patience;
  poll();
  while (!receiver_.is_whole(frame)) {
    const Duration left = until - clock_.now();
    if (left <= Duration::zero() || !channel_ || !receiver_.may_come(frame) || gives_up_()) return false;
    keep_session();
    receive_one(std::min(left, kHelloInterval));
  }
  return true;
}

std::optional<Time> NetworkLink::silent_since() const {
  const std::optional<Time> since = !channel_                  ? first_hello_
                                    : channel_->unanswered > 0 ? std::optional(channel_->requested)
                                                               : std::nullopt;
  return since && (goodbye_ || clock_.now() - *since > kSilentAfter) ? since : std::nullopt;
}

NetworkLink::Counters NetworkLink::counters() const {
  return {receiver_.counters(), undecodable_,
          port_.counters(),     sessions_,
          cut_short_,           channel_ ? channel_->arrivals.missing() : 0};
}

}  // namespace farshade
