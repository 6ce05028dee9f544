#include "rt_server/core/server_core.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "stereo/base/check.h"
#include "stereo/net/explain.h"

namespace farshade {
namespace {

constexpr Duration kLongWait = std::chrono::seconds(60);  // wake() ends it earlier

void log(const Sessions::Event& event) {
  if (event.refused)
    spdlog::warn("refused {} at {}: {}", event.name, to_string(event.client), name_of(*event.refused));
  else
    spdlog::info("welcomed {} at {}", event.name, to_string(event.client));
}

/// For example " (3 forged, 1 replayed)".
std::string reasons(const RefusalCounts& refused) {
  std::string text;
  for (std::size_t i = 0; i < kWireRefusals; ++i)
    if (refused.of[i] > 0)
      text += fmt::format("{}{} {}", text.empty() ? " (" : ", ", refused.of[i],
                          name_of(static_cast<WireRefusal>(i)));
  return text.empty() ? text : text + ")";
}

Welcome with_answers(Welcome served, AnswerSet answers) {
  served.answers = answers;
  return served;
}

}  // namespace

std::string counters_line(const ServerCounters& counters) {
  const SessionCounters& sessions = counters.sessions;
  const GateCounters& gate = counters.gate;
  return fmt::format(
      "rt_server: {} clients, {} requests, {} superseded, {} outdated, {} too large, {} for answers "
      "not offered, {} stray parts of requests, {} frames, {} datagrams and {} bytes sent, {} unsent, {} "
      "datagrams "
      "received, {} oversized, {} refused{}; hellos: {} without a cookie, {} repeated; not admitted: {} of "
      "another version, {} without a known key, {} of another scene, {} because the server was full, {} over "
      "the handshake limit; sessions: {} open, {} timed out, {} replaced, {} ended because their answer is "
      "no longer offered, {} moved; {} frames slowed by --bytes-per-second",
      sessions.welcomed, sessions.requests, sessions.superseded, sessions.outdated, sessions.too_large,
      sessions.unanswered, sessions.stray, counters.frames, counters.port.sent, counters.port.sent_bytes,
      counters.port.unsent, counters.port.received, counters.port.oversized, counters.refused.total(),
      reasons(counters.refused), gate.retries, sessions.repeated, gate.version_mismatch, gate.unknown_key,
      sessions.scene_mismatch, sessions.busy, gate.too_many, counters.sessions_open, sessions.forgotten,
      sessions.replaced, sessions.withdrawn, sessions.moved, sessions.held_back);
}

std::string rays_line(const TraceStats& traced) {
  return fmt::format(
      "rt_server: rays: {} from eyes, {} to lights, of {} covered pixels times lights; the others needed "
      "none: {} turned away, {} out of range, {} out of cone, {} proved in sight",
      traced.primary_rays, traced.shadow_rays, traced.full_shadow_rays, traced.turned_away,
      traced.out_of_range, traced.out_of_cone, traced.proven);
}

ServerCore::ServerCore(Welcome served, const std::vector<SharedKey>& ring, AnswerMakers answers,
                       DatagramPort& port, const Clock& clock, const SessionLimits& limits)
    : port_(port),
      clock_(clock),
      answers_(std::move(answers)),
      sessions_(with_answers(served, answers_.offered()), ring, limits) {}

bool ServerCore::receive(Duration wait) {
  std::array<std::byte, kMaxDatagram_bytes> buffer;
  const std::optional<Datagram> datagram = port_.receive(buffer, wait);
  if (!datagram) return false;
  bool is_request_waiting = false;
  std::optional<Sessions::Event> event;
  {
    const std::lock_guard lock(mutex_);
    const Decoded<void> taken = sessions_.handle(datagram->from, datagram->bytes, clock_.now(), datagram_);
    if (!taken) refused_.count(taken.error());
    is_request_waiting = sessions_.job_at().has_value();
    event = sessions_.take_event();
  }
  if (is_request_waiting) request_arrived_.notify_one();
  if (!datagram_.empty()) port_.send(datagram->from, datagram_);
  if (event) log(*event);
  return true;
}

void ServerCore::send_due() {
  Peer to;
  const auto seal = [&] {
    const std::lock_guard lock(mutex_);
    return sessions_.seal_due(clock_.now(), to, datagram_);
  };
  bool sent = false;
  for (; seal(); sent = true) port_.send(to, datagram_);
  if (sent) request_arrived_.notify_one();  // a request waits until its client's last frame was sent
}

std::optional<Time> ServerCore::next_send() const {
  const std::lock_guard lock(mutex_);
  return sessions_.due_at();
}

std::optional<Time> ServerCore::next_due() const {
  const std::lock_guard lock(mutex_);
  const std::optional<Time> send = sessions_.due_at(), work = sessions_.job_at();
  return send && work ? std::min(*send, *work) : send ? send : work;
}

bool ServerCore::wait_for_work(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    const std::optional<Time> at = sessions_.job_at();
    const Time now = clock_.now();
    if (at && *at <= now) return true;
    const auto has_changed = [&] { return sessions_.job_at() != at; };
    if (at)
      request_arrived_.wait_for(lock, stop, *at - now, has_changed);
    else
      request_arrived_.wait(lock, stop, has_changed);
  }
  return false;
}

bool ServerCore::work() {
  std::optional<Job> job;
  {
    const std::lock_guard lock(mutex_);
    job = sessions_.next_job(clock_.now());
  }
  if (!job) return false;
  const Time begun = clock_.now();
  const AnswerSet offered_before = answers_.offered();
  packer_.begin();
  const auto [traced, draw, coding] = answers_.answer(*job, packer_, begun);
  const FrameReport report{.frame = job->request.frame,
                           .primary_rays = traced.primary_rays,
                           .shadow_rays = traced.shadow_rays,
                           .full_shadow_rays = traced.full_shadow_rays,
                           .primary = traced.primary,
                           .shadow = traced.shadow,
                           .draw = draw,
                           .pack = coding,
                           .waited = begun - job->arrived,
                           .superseded = job->superseded,
                           .bytes_per_second = job->bytes_per_second,
                           .view_scale = job->view_scale};
  const auto messages = packer_.finish(report);
  {
    const std::lock_guard lock(mutex_);
    const Time now = clock_.now();
    sessions_.put(job->session, messages, now - begun, now);
    if (answers_.offered() != offered_before) sessions_.offer(answers_.offered());
    traced_ += traced;
  }
  answered_at_ = clock_.now();
  ++frames_;
  wake();
  return true;
}

ServerCounters ServerCore::counters() const {
  const std::lock_guard lock(mutex_);
  return {sessions_.counters(), sessions_.gate(), refused_, port_.counters(), frames_,
          sessions_.size(),     traced_};
}

bool ServerCore::answered_within(Duration span) const {
  return frames_ > 0 && clock_.now() - answered_at_.load() <= span;
}

Serving::Serving(ServerCore& core)
    : core_(core),
      network_([&core](const std::stop_token& stop) {
        while (!stop.stop_requested()) {
          const std::optional<Time> due = core.next_send();
          core.receive(due ? std::clamp(*due - core.clock().now(), Duration::zero(), kLongWait) : kLongWait);
          core.send_due();
        }
      }),
      worker_([&core](const std::stop_token& stop) {
        while (core.wait_for_work(stop)) core.work();
      }) {}

Serving::~Serving() {
  network_.request_stop();
  worker_.request_stop();
  core_.wake();
}

}  // namespace farshade
