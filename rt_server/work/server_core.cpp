#include "rt_server/work/server_core.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <new>
#include <utility>

#include "stereo/base/check.h"

namespace farshade {
namespace {

constexpr Duration kLookInterval = std::chrono::milliseconds(10);
/// A wait that ends so much later was not one: the process was stopped, or the machine slept.
constexpr Duration kStall = std::chrono::seconds(1);
constexpr Duration kLongWait = std::chrono::seconds(60);  // wake() ends it earlier

std::optional<Time> earlier(std::optional<Time> a, std::optional<Time> b) {
  return a && b ? std::min(*a, *b) : a ? a : b;
}

struct Count {
  std::uint64_t number;
  std::string_view of;
};

/// For example "3 forged, 1 replayed": those that are not 0.
std::string list(std::span<const Count> counts) {
  std::string text;
  for (const Count& count : counts)
    if (count.number > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count.number, count.of);
  return text;
}

/// "; hellos: " and the like before a list, if it is not empty.
std::string group(std::string_view name, std::initializer_list<Count> counts) {
  const std::string text = list(counts);
  return text.empty() ? text : fmt::format("; {}: {}", name, text);
}

std::string refusals(const RefusalCounts& refused) {
  std::vector<Count> counts;
  for (std::size_t i = 0; i < kWireRefusals; ++i)
    counts.push_back({refused.of[i], name_of(static_cast<WireRefusal>(i))});
  const std::string text = list(counts);
  return text.empty() ? text : fmt::format("; {} refused ({})", refused.total(), text);
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
             "rt_server: {} clients, {} requests, {} frames, {} datagrams and {} bytes sent, {} datagrams "
             "received",
             sessions.welcomed, sessions.requests, counters.frames, counters.port.sent,
             counters.port.sent_bytes, counters.port.received) +
         group("of the requests",
               {{sessions.superseded, "superseded"},
                {sessions.outdated, "outdated"},
                {sessions.too_large, "too large"},
                {sessions.unanswered, "for answers not offered"},
                {sessions.stray, "stray parts of requests"},
                {sessions.too_costly, "too costly"},
                {counters.given_up, "given up"},
                {counters.rebuilt_too_often, "of a key that changes sizes or bit rates too often"}}) +
         group("memory", {{sessions.over_memory, "refused by --memory"},
                          {counters.out_of_memory, "dropped because none was left"}}) +
         refusals(counters.refused) +
         group("not delivered", {{counters.port.unsent, "unsent"}, {counters.port.oversized, "oversized"}}) +
         group("hellos", {{gate.retries, "without a cookie"}, {sessions.repeated, "repeated"}}) +
         group("not admitted", {{gate.version_mismatch, "of another version"},
                                {gate.unknown_key, "without a known key"},
                                {gate.expired_key, "with a key that has expired"},
                                {sessions.scene_mismatch, "of another scene"},
                                {sessions.busy, "because the server was full"},
                                {sessions.key_full, "because their key had all its sessions"},
                                {gate.too_many, "over the handshake limit"},
                                {sessions.ignored, "while the key ring could not be read"}}) +
         group("sessions", {{counters.sessions_open, "open"},
                            {sessions.left, "ended by their clients"},
                            {sessions.forgotten, "timed out"},
                            {sessions.replaced, "replaced"},
                            {sessions.displaced, "ended for a key with fewer"},
                            {sessions.withdrawn, "ended because their answer is no longer offered"},
                            {sessions.revoked, "ended because their key was taken out of the ring"},
                            {sessions.expired, "ended because their key has expired"},
                            {sessions.moved, "moved"},
                            {sessions.false_reports, "that reported what was never sent"}}) +
         group("paths", {{sessions.widened, "found to carry larger datagrams"},
                         {sessions.black_holes, "stopped to carry large datagrams"}}) +
         group("frames", {{sessions.held_back, "slowed by --bytes-per-second"},
                          {sessions.overtaken, "overtaken by a newer one"}});
}

std::string rays_line(const TraceStats& traced) {
  return fmt::format(
      "rt_server: rays: {} from eyes, {} to lights, of {} covered pixels times lights; the others needed "
      "none: {} turned away, {} out of range, {} out of cone",
      traced.primary_rays, traced.shadow_rays, traced.full_shadow_rays, traced.turned_away,
      traced.out_of_range, traced.out_of_cone);
}

ServerCore::ServerCore(Welcome served, const std::vector<SharedKey>& ring, RequestHandlers answers,
                       DatagramPort& port, const Clock& clock, const SessionLimits& limits)
    : port_(port),
      clock_(clock),
      answers_(std::move(answers)),
      sessions_(with_answers(served, answers_.offered()), ring, limits) {}

bool ServerCore::receive(Duration wait) try { return receive_datagram(wait); } catch (const std::bad_alloc&) {
  ++out_of_memory_;
  return true;
}

bool ServerCore::receive_datagram(Duration wait) {
  std::array<std::byte, kBaseDatagram_bytes> buffer;
  const Time asked = clock_.now();
  const std::optional<Datagram> datagram = port_.receive(buffer, wait);
  bool is_request_waiting = false;
  std::vector<ClientEvent> events;
  {
    const std::lock_guard lock(mutex_);
    const Time now = clock_.now();
    if (const Duration late = now - asked - wait; late > kStall) sessions_.forgive(late, now);
    if (datagram) {
      const Decoded<void> taken = sessions_.handle(datagram->from, datagram->bytes, now, datagram_);
      if (!taken) refused_.count(taken.error());
      is_request_waiting = sessions_.was_opened() && sessions_.job_at().has_value();
    } else {
      sessions_.end_silent(now);
    }
    events = sessions_.take_events();
  }
  if (is_request_waiting) request_arrived_.notify_one();
  if (datagram && !datagram_.empty()) port_.send(datagram->from, datagram_);
  for (const ClientEvent& event : events) log(event);
  return datagram.has_value();
}

void ServerCore::log(const ClientEvent& event) {
  std::string words = in_words(event);
  if (is_fault(event.kind)) {
    const std::optional<std::string> line = refusals_.failed({event.kind, event.key}, words, clock_.now());
    if (!line) return;
    words = *line;
  }
  spdlog::log(is_fault(event.kind) ? spdlog::level::warn : spdlog::level::info, "{}", words);
}

void ServerCore::set_ring(const std::vector<SharedKey>& ring, std::chrono::sys_days today) {
  {
    const std::lock_guard lock(mutex_);
    sessions_.set_ring(ring, today);
  }
  request_arrived_.notify_one();  // what was held for a key that has gone may begin
  wake();
}

void ServerCore::admit(Newcomers newcomers) {
  const std::lock_guard lock(mutex_);
  sessions_.admit(newcomers);
}

void ServerCore::say_goodbye() {
  const auto next = [&]() -> std::optional<Time> {
    const std::lock_guard lock(mutex_);
    return sessions_.goodbye_at();
  };
  {
    const std::lock_guard lock(mutex_);
    sessions_.say_goodbye();
  }
  std::array<std::byte, kBaseDatagram_bytes> ignored;
  for (std::optional<Time> at; (at = next());) {
    if (const Duration wait = *at - clock_.now(); wait > Duration::zero())
      static_cast<void>(port_.receive(ignored, wait));
    send_due();
  }
}

void ServerCore::send_due() try { send_all_due(); } catch (const std::bad_alloc&) {
  ++out_of_memory_;
}

void ServerCore::send_all_due() {
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
  return earlier(sessions_.due_at(), sessions_.job_at());
}

std::optional<Time> ServerCore::next_end() const {
  const std::lock_guard lock(mutex_);
  return sessions_.silent_at();
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

/// Called by all cores of a trace, often: looks at the sessions, which are behind a lock, every 10 ms only.
bool ServerCore::is_given_up(const std::stop_token& stop) {
  if (stop.stop_requested()) return true;
  const Time now = clock_.now();
  Time look = next_look_.load();
  if (now < look || !next_look_.compare_exchange_strong(look, now + kLookInterval)) return false;
  const std::lock_guard lock(mutex_);
  return sessions_.gives_up(now);
}

ServerCore::Answered ServerCore::answer(Job& job, Time begun, const std::stop_token& stop) {
  std::atomic<bool> given_up = false;
  job.is_given_up = [&] {
    if (is_given_up(stop)) given_up = true;
    return given_up.load();
  };
  packer_.begin(job.most_message_bytes, job.version);
  const auto [traced, draw, coding, lacked_memory, rebuilt_too_often, too_large] =
      job.is_too_costly ? AnswerCost{} : answers_.answer(job, packer_, begun);
  if (lacked_memory) ++out_of_memory_;
  if (rebuilt_too_often) ++rebuilt_too_often_;
  const bool lacks_content = given_up || job.is_too_costly || lacked_memory || rebuilt_too_often || too_large;
  const FrameReport report{.frame = job.request.frame,
                           .primary_rays = traced.primary_rays,
                           .shadow_rays = traced.shadow_rays,
                           .full_shadow_rays = traced.full_shadow_rays,
                           .update = traced.update,
                           .primary = traced.primary,
                           .shadow = traced.shadow,
                           .draw = draw,
                           .pack = coding,
                           .waited = begun - job.arrived,
                           .superseded = job.superseded,
                           .bytes_per_second = job.bytes_per_second,
                           .view_scale = job.view_scale};
  if (given_up) ++given_up_;
  return {packer_.finish(report), traced, lacks_content ? JobEnd::GivenUp : JobEnd::Answered};
}

bool ServerCore::work(const std::stop_token& stop) try {
  std::optional<Job> job;
  {
    const std::lock_guard lock(mutex_);
    job = sessions_.next_job(clock_.now());
  }
  if (!job) return false;
  const Time begun = clock_.now();
  const AnswerSet offered_before = answers_.offered();
  Answered answered = answer(*job, begun, stop);
  {
    const std::lock_guard lock(mutex_);
    const Time now = clock_.now();
    sessions_.put(job->session, std::move(answered.messages), now - begun, now, answered.end);
    if (answers_.offered() != offered_before) sessions_.offer(answers_.offered());
    traced_ += answered.traced;
  }
  answered_at_ = clock_.now();
  ++frames_;
  wake();
  return true;
} catch (const std::bad_alloc&) {
  ++out_of_memory_;
  return true;
}

ServerCounters ServerCore::counters() const {
  const std::lock_guard lock(mutex_);
  return {
      sessions_.counters(), sessions_.gate(), refused_,         port_.counters(),       frames_, given_up_,
      rebuilt_too_often_,   out_of_memory_,   sessions_.size(), sessions_.held_bytes(), traced_};
}

bool ServerCore::answered_within(Duration span) const {
  return frames_ > 0 && clock_.now() - answered_at_.load() <= span;
}

Serving::Serving(ServerCore& core)
    : core_(core),
      network_([&core](const std::stop_token& stop) {
        while (!stop.stop_requested()) {
          const std::optional<Time> due = earlier(core.next_send(), core.next_end());
          core.receive(due ? std::clamp(*due - core.clock().now(), Duration::zero(), kLongWait) : kLongWait);
          core.send_due();
        }
      }),
      worker_([this, &core](const std::stop_token& stop) {
        while (core.wait_for_work(stop)) core.work(stop);
        worker_has_ended_.set_value();
      }) {}

bool Serving::end(Duration patience) {
  network_.request_stop();
  worker_.request_stop();
  core_.wake();
  network_.join();
  return worker_has_ended_.get_future().wait_for(patience) == std::future_status::ready;
}

Serving::~Serving() {
  network_.request_stop();
  worker_.request_stop();
  core_.wake();
}

}  // namespace farshade
