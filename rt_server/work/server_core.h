/// ServerCore: the server without its threads and its socket. receive() takes datagrams, work() answers
/// requests, send_due() sends the datagrams of the answers. A program calls them from two threads (Serving);
/// a test or a study calls them in turn over a virtual link.
#pragma once

#include <atomic>
#include <condition_variable>
#include <future>
#include <map>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

#include "rt_server/sessions/sessions.h"
#include "rt_server/work/request_handlers.h"

namespace farshade {

struct ServerCounters {
  SessionCounters sessions;
  GateCounters gate;
  RefusalCounts refused;  ///< received datagrams that were refused: malformed, or of no session
  PortCounters port;
  std::uint64_t frames = 0;             ///< requests answered
  std::uint64_t given_up = 0;           ///< of them: without content, because work on them was given up
  std::uint64_t rebuilt_too_often = 0;  ///< of the frames: without content for RebuiltTooOften
  std::uint64_t out_of_memory = 0;  ///< answers without content and datagrams dropped because memory ran out
  std::size_t sessions_open = 0;    ///< now
  std::size_t held_bytes = 0;       ///< memory of the sessions now
  TraceStats traced;                ///< sum over all frames
};

/// One line for a person at a terminal. It names only what has happened, beyond the numbers of clients,
/// requests, frames and datagrams.
[[nodiscard]] std::string counters_line(const ServerCounters& counters);

/// The rays traced, and the reasons why pixel-lights needed none, in one line.
[[nodiscard]] std::string rays_line(const TraceStats& traced);

/// One thread may call receive(), send_due(), next_due() and next_send() while another calls wait_for_work()
/// and work(). Any thread may call counters().
class ServerCore {
 public:
  /// `served` describes the scene to clients; its `answers` are replaced by what `answers` offers. Clients
  /// need a key of `ring`. `port` and `clock` must outlive the core.
  ServerCore(Welcome served, const std::vector<SharedKey>& ring, RequestHandlers answers, DatagramPort& port,
             const Clock& clock, const SessionLimits& limits = {});

  /// Waits at most `wait` for the next datagram, processes it, and sends the reply if it has one (handshake,
  /// probe). Requests wait for work(). Returns false if no datagram came. A datagram for which there is no
  /// memory is dropped and counted.
  bool receive(Duration wait);

  /// From now on serves only clients with these keys, if they are valid on `today`; any thread may call it.
  void set_ring(const std::vector<SharedKey>& ring, std::chrono::sys_days today = {});

  /// Whether clients without a session are admitted; any thread may call it.
  void admit(Newcomers newcomers);

  /// Tells all clients that the server ends: kGoodbyes times, which takes a moment. Only when no other thread
  /// receives and sends any more.
  void say_goodbye();

  /// Sends all datagrams that are due.
  void send_due();

  /// When send_due() or work() next has something to do if no datagram arrives.
  [[nodiscard]] std::optional<Time> next_due() const;
  /// When send_due() next has something to do.
  [[nodiscard]] std::optional<Time> next_send() const;

  /// When receive() has something to do although no datagram arrives: a session of a silent client ends.
  [[nodiscard]] std::optional<Time> next_end() const;

  /// Answers the newest request of the client whose turn it is, and puts the datagrams into its outbox.
  /// Returns false if no request is ready. Work on an answer is given up when `stop` is requested, when its
  /// session has ended, or when it takes too long for others (Sessions::gives_up).
  bool work(const std::stop_token& stop = {});

  /// Blocks until a request is ready. Returns false when `stop` was requested.
  bool wait_for_work(const std::stop_token& stop);

  /// Ends the receive() that is waiting, or the next one.
  void wake() { port_.wake(); }

  [[nodiscard]] ServerCounters counters() const;
  /// Whether a request was answered in the last `span`. Any thread may call it.
  [[nodiscard]] bool answered_within(Duration span) const;
  [[nodiscard]] const Clock& clock() const { return clock_; }

 private:
  struct Answered {
    std::vector<std::vector<std::byte>> messages;
    TraceStats traced{};
    JobEnd end = JobEnd::Answered;
  };
  bool receive_datagram(Duration wait);
  void send_all_due();
  [[nodiscard]] Answered answer(Job& job, Time begun, const std::stop_token& stop);
  [[nodiscard]] bool is_given_up(const std::stop_token& stop);

  DatagramPort& port_;
  const Clock& clock_;

  // Used by the thread that calls work().
  RequestHandlers answers_;
  FramePacker packer_;
  std::atomic<std::uint64_t> frames_ = 0, given_up_ = 0, rebuilt_too_often_ = 0, out_of_memory_ = 0;
  std::atomic<Time> next_look_{};    ///< of is_given_up()
  std::atomic<Time> answered_at_{};  ///< the last request, if frames_ is not 0

  mutable std::mutex mutex_;  ///< guards sessions_, refused_ and traced_
  std::condition_variable_any request_arrived_;
  Sessions sessions_;
  RefusalCounts refused_;
  TraceStats traced_;

  // Used by the thread that calls receive() and send_due().
  void log(const ClientEvent& event);
  /// By reason and key; strangers have one entry for all.
  /// A ring has at most kMaxRingKeys, with four reasons each. More entries are of keys that have gone, and
  /// all are forgotten.
  FailureLogs<std::pair<ClientEvent::Kind, std::optional<KeyId>>> refusals_{4 * kMaxRingKeys};
  std::vector<std::byte> datagram_;
};

/// The two threads of a server: one receives and sends datagrams, the other answers requests.
class Serving {
 public:
  /// Starts both threads. `core` must outlive this object.
  explicit Serving(ServerCore& core);
  Serving(const Serving&) = delete;
  Serving& operator=(const Serving&) = delete;
  /// Ends both threads. Gives up the answer in work, if it can be given up.
  ~Serving();

  /// The same, but waits no longer than `patience`. Returns false if the answer in work takes longer: it is
  /// drawn, and nothing interrupts a graphics device.
  [[nodiscard]] bool end(Duration patience);

 private:
  ServerCore& core_;
  std::promise<void> worker_has_ended_;
  std::jthread network_, worker_;
};

}  // namespace farshade
