#include "vr_client/shadow_link.h"

#include <algorithm>

#include "stereo/base/check.h"
#include "stereo/net/explain.h"

namespace farshade {
namespace {

/// Between two hellos to a server that has not answered.
constexpr Duration kHelloInterval = std::chrono::milliseconds(250);

}  // namespace

ShadowLink::ShadowLink(DatagramPort& port, const Peer& server, const Clock& clock,
                       const SceneHash& scene_hash, std::uint32_t lights, std::size_t frames)
    : port_(port),
      server_(server),
      clock_(clock),
      scene_hash_(scene_hash),
      lights_(lights),
      assembler_(frames),
      frames_(frames) {}

void ShadowLink::send(const ClientMessage& message) {
  encode(message, outgoing_);
  port_.send(server_, outgoing_);
}

void ShadowLink::say_hello() {
  if (refused_ || (last_hello_ && clock_.now() - *last_hello_ < kHelloInterval)) return;
  last_hello_ = clock_.now();
  send(Hello{.scene_hash = scene_hash_});
}

Expected<void> ShadowLink::meet(Duration patience) {
  const Time until = clock_.now() + patience;
  while (!welcomed_ && !refused_ && clock_.now() < until) {
    say_hello();
    receive_one(std::min(kHelloInterval, until - clock_.now()));
  }
  if (refused_) return tl::unexpected(*refused_);
  if (!welcomed_ && busy_server_) return fail(Fault::Unavailable, *busy_server_);
  if (!welcomed_) return fail(Fault::Missing, "no server answers at " + to_string(server_));
  return {};
}

void ShadowLink::request(const TraceRequest& request, Time asked_at) {
  if (!welcomed_) {
    say_hello();
    return;
  }
  std::optional<FrameId> newest;
  if (const ReceivedFrame* frame = assembler_.newest_known()) newest = frame->request.frame;
  assembler_.expect(request, lights_, light_set_revision_);
  asked_.push_back({request.frame, asked_at});
  if (asked_.size() > frames_) asked_.erase(asked_.begin());
  send(RequestMessage{request, newest});
}

bool ShadowLink::receive_one(Duration wait) {
  const std::optional<Datagram> datagram = port_.receive(incoming_, wait);
  if (!datagram) return false;
  const Stopwatch watch;
  const Decoded<ServerMessage> message = decode_server(datagram->bytes);
  if (message)
    std::visit([this](const auto& m) { take(m); }, *message);
  else
    undecodable_.count(message.error());
  busy_ += watch.elapsed();
  return true;
}

void ShadowLink::poll() {
  while (receive_one(Duration::zero())) {
  }
}

bool ShadowLink::wait_for(FrameId frame, Duration patience) {
  const Time until = clock_.now() + patience;
  const auto whole = [&] {
    const ReceivedFrame* received = assembler_.find(frame);
    return received != nullptr && received->complete() && received->report.has_value();
  };
  poll();
  while (!whole()) {
    const Duration left = until - clock_.now();
    if (left <= Duration::zero() || !welcomed_) return false;
    receive_one(left);
  }
  return true;
}

std::vector<const ReceivedFrame*> ShadowLink::masks(Time until) const {
  std::vector<const ReceivedFrame*> found;
  for (auto asked = asked_.rbegin(); asked != asked_.rend(); ++asked)
    if (const ReceivedFrame* received = assembler_.find(asked->frame);
        received && received->anything_known() && asked->at <= until)
      found.push_back(received);
  return found;
}

std::optional<Time> ShadowLink::asked_at(FrameId frame) const {
  const auto asked = std::ranges::find(asked_, frame, &Asked::frame);
  return asked == asked_.end() ? std::nullopt : std::optional(asked->at);
}

void ShadowLink::take(const Welcome& welcome) {
  if (welcome.scene_hash != scene_hash_ || welcome.light_count != lights_) {
    refused_ = Error{Fault::Mismatch, "the server at " + to_string(server_) + " serves another scene"};
    return;
  }
  light_set_revision_ = welcome.light_set_revision;
  welcomed_ = true;
}

void ShadowLink::take(const Refusal& refusal) {
  switch (refusal.reason) {
    case RefusalReason::NotWelcomed:  // the server was restarted, or forgot us: say hello again
      welcomed_ = false;
      say_hello();
      break;
    case RefusalReason::Busy:
      welcomed_ = false;
      busy_server_ = explain(refusal, Hello{.scene_hash = scene_hash_});
      break;
    default:
      welcomed_ = false;
      refused_ = Error{Fault::Mismatch, explain(refusal, Hello{.scene_hash = scene_hash_})};
  }
}

ShadowLink::Counters ShadowLink::counters() const {
  return {assembler_.counters(), undecodable_, port_.counters()};
}

}  // namespace farshade
