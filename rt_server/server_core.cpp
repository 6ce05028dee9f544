#include "rt_server/server_core.h"

#include <spdlog/spdlog.h>

#include <utility>

#include "stereo/net/explain.h"

namespace farshade {

std::string closing_line(const ServerCounters& counters) {
  const SessionCounters& sessions = counters.sessions;
  return fmt::format(
      "rt_server: {} clients, {} requests, {} superseded, {} outdated, {} frames, {} datagrams and {} bytes "
      "sent, "
      "{} unsent, {} datagrams received, {} of them refused",
      sessions.welcomed, sessions.requests, sessions.superseded, sessions.outdated, counters.frames,
      counters.port.sent, counters.port.sent_bytes, counters.port.unsent, counters.port.received,
      counters.refused.total());
}

ServerCore::ServerCore(const Welcome& served, TraceFunction trace, DatagramPort& port, const Clock& clock,
                       SessionLimits limits)
    : trace_(std::move(trace)), port_(port), clock_(clock), sessions_(served, limits) {}

bool ServerCore::receive(Duration wait) {
  std::array<std::byte, kMaxDatagram_bytes> buffer;
  const std::optional<Datagram> datagram = port_.receive(buffer, wait);
  if (!datagram) return false;
  const Decoded<ClientMessage> message = decode_client(datagram->bytes);
  std::optional<ServerMessage> answer;
  bool somebody_waits = false;
  {
    const std::lock_guard lock(mutex_);
    if (message) {
      answer = sessions_.handle(datagram->from, *message, clock_.now());
      somebody_waits = sessions_.has_job();
    } else {
      refused_.count(message.error());
    }
  }
  if (somebody_waits) somebody_waits_.notify_one();
  if (answer) {
    encode(*answer, answer_bytes_);
    port_.send(datagram->from, answer_bytes_);
    log_answer(datagram->from, *message, *answer);
  }
  return true;
}

bool ServerCore::wait_for_work(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  return somebody_waits_.wait(lock, stop, [&] { return sessions_.has_job(); }) && !stop.stop_requested();
}

bool ServerCore::work() {
  std::optional<Job> job;
  {
    const std::lock_guard lock(mutex_);
    job = sessions_.next_job();
  }
  if (!job) return false;
  const Duration waited = clock_.now() - job->arrived;
  const TraceStats stats = trace_(job->request, frame_);
  const FrameReport report{.frame = job->request.frame,
                           .primary_rays = stats.primary_rays,
                           .shadow_rays = stats.shadow_rays,
                           .full_shadow_rays = stats.full_shadow_rays,
                           .primary = stats.primary,
                           .shadow = stats.shadow,
                           .waited = waited,
                           .superseded = job->superseded};
  for (const std::vector<std::byte>& datagram : packer_.pack(frame_, report))
    port_.send(job->client, datagram);
  ++frames_;
  return true;
}

ServerCounters ServerCore::counters() const {
  const std::lock_guard lock(mutex_);
  return {sessions_.counters(), refused_, port_.counters(), frames_};
}

void ServerCore::log_answer(const Peer& client, const ClientMessage& message, const ServerMessage& answer) {
  const auto* hello = std::get_if<Hello>(&message);
  if (hello == nullptr) return;
  const auto* refusal = std::get_if<Refusal>(&answer);
  // A client repeats its hello until it is heard; people need to read the answer once.
  const std::pair said(client, refusal == nullptr ? std::nullopt : std::optional(refusal->reason));
  if (std::exchange(last_logged_, said) == said) return;
  if (refusal == nullptr) {
    spdlog::info("welcomed {}", to_string(client));
  } else {
    spdlog::warn("refused {}: {}", to_string(client), explain(*refusal, *hello));
  }
}

}  // namespace farshade
