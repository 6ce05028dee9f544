/// ClientSession: everything that the server stores for one client that has proved its address and its key:
/// the keys of the session, the path to the client, what it has requested and what is being sent to it. A
/// value of bounded size, without sockets, threads or clocks. Sessions share no data.
#pragma once

#include <algorithm>
#include <optional>
#include <string>

#include "rt_server/scheduling/quality.h"
#include "rt_server/sessions/client_path.h"
#include "rt_server/sessions/outbox.h"
#include "rt_server/sessions/waiting_requests.h"
#include "stereo/sealing/handshake.h"

namespace farshade {

/// Memory of a session in which nothing waits: 141,425 bytes were measured, most of them what the rate
/// control remembers.
inline constexpr std::size_t kSession_bytes = 144 << 10;

class ClientSession {
 public:
  ClientSession(const SharedKey& key, const Peer& client, const PublicKey& hello, const Accepted& accepted,
                Time now, const RateLimits& limits, const Welcome& served);

  /// Sets the limits of the rate from now on.
  void limit(const RateLimits& limits) { path_.limit(limits); }

  [[nodiscard]] SessionId id() const { return id_; }
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const KeyId& key() const { return key_; }
  [[nodiscard]] const Peer& client() const { return path_.client(); }
  /// The public key of the hello that began the session.
  [[nodiscard]] const PublicKey& hello() const { return hello_; }
  /// The answer to that hello. The server sends it again if the hello arrives again.
  [[nodiscard]] std::span<const std::byte> accept_datagram() const { return accept_; }
  [[nodiscard]] Time began() const { return began_; }
  [[nodiscard]] Time last_received() const { return last_received_; }
  /// The client was not heard for the `stall` before `now`, and that was not its fault.
  void forgive(Duration stall, Time now) { last_received_ = std::min(now, last_received_ + stall); }
  /// A sealed datagram of the client has been opened, so the client has the session keys.
  [[nodiscard]] bool is_confirmed() const { return confirmed_; }

  /// Opens `sealed`, which was read from `datagram`, and processes its message. `reply` becomes a datagram to
  /// send to `from` at once, or is left empty. The session may take `room` more bytes of memory.
  [[nodiscard]] Decoded<ReceivedMessage> receive(const Peer& from, const Sealed& sealed,
                                                 std::span<const std::byte> datagram, Time now,
                                                 std::vector<std::byte>& reply,
                                                 std::size_t room = kMostParts_bytes);

  /// Memory that it holds.
  [[nodiscard]] std::size_t bytes() const { return kSession_bytes + requests_.bytes() + outbox_.bytes(); }

  [[nodiscard]] bool has_requested() const { return requests_.any(); }
  /// The kind of answer that the last accepted request wants; none before the first.
  [[nodiscard]] std::optional<Answer> requested_answer() const { return requests_.requested_answer(); }
  /// From now on accepts only requests for `answers`.
  void offer(AnswerSet answers) { requests_.offer(answers); }

  /// When the path has become slower, a newer frame overtakes an older one that would end this much later
  /// than it was expected to end when it was put into the outbox.
  static constexpr Duration kMostLate = std::chrono::milliseconds(100);

  /// A request is complete, and the path has taken the whole previous frame, or it is to be overtaken.
  [[nodiscard]] bool is_ready(Time now) const {
    const std::optional<Time> at = ready_at();
    return at && now >= *at;
  }
  /// When is_ready() becomes true if nothing else happens.
  [[nodiscard]] std::optional<Time> ready_at() const;
  /// Removes the waiting request. Only when is_ready().
  [[nodiscard]] Job take_job();

  /// Of the sessions of one key, the one with the least Turn is served next.
  struct Turn {
    Duration work{};           ///< spent on this client; a new client starts at the value of the others
    std::uint64_t served = 0;  ///< number of jobs of all clients when this one was last served, or came
    friend auto operator<=>(const Turn&, const Turn&) = default;
  };
  Turn turn;

  /// What became of a frame that was put into the outbox.
  struct PutFrame {
    bool is_held_back;  ///< it leaves more slowly because of the limit of bytes per second
    bool overtakes;     ///< it has replaced the rest of an older one
  };
  /// Queues the messages of an answer. They leave evenly over a share of the frame interval; those of the
  /// cube mask, which delay the next answer, as fast as the path takes them.
  PutFrame put(std::vector<std::vector<std::byte>> messages, Time now, JobEnd end = JobEnd::Answered);

  /// When seal_due() has a message to send.
  [[nodiscard]] std::optional<Time> due() const { return outbox_.due(); }
  /// Removes the next message from the queue and seals it into `datagram`.
  void seal_due(Time now, std::vector<std::byte>& datagram);

  /// Seals the last message of this session into `datagram`.
  void seal_goodbye(EndReason reason, std::vector<std::byte>& datagram);

  /// The client has reported the arrival of a datagram that was never sent. Since then it gets the least
  /// rate.
  [[nodiscard]] bool got_false_report() const { return path_.rate.got_false_report(); }
  /// The largest datagram that the path to the client's present address is known to carry, in bytes.
  [[nodiscard]] std::size_t most_datagram_bytes() const { return path_.mtu.bytes(); }
  /// Times that the path to the client's present address stopped to carry large datagrams.
  [[nodiscard]] std::uint64_t black_holes() const { return path_.mtu.black_holes(); }

  /// One of so many datagrams, on average and at random, is followed by a counter that no datagram has.
  static constexpr std::uint32_t kBetweenGaps = 512;

 private:
  [[nodiscard]] bool is_late() const;
  ReceivedMessage receive_request(const Peer& from, const RequestMessage& message, bool newest, Time now,
                                  std::vector<std::byte>& reply);
  /// Returns the counter, which the caller tells the rate control.
  std::uint64_t seal_probe(std::uint64_t token, std::vector<std::byte>& probe);
  void probe_path(Time now, std::vector<std::byte>& probe);
  void record_sent(std::uint64_t counter, std::size_t bytes, Time now);

  std::string name_;
  KeyId key_;
  SessionId id_;
  ProtocolVersion version_;
  PublicKey hello_;
  std::vector<std::byte> accept_;
  Opener opener_;
  Sealer sealer_;
  std::uint32_t until_gap_;  ///< datagrams to the next counter that is left out
  std::vector<std::byte> message_;

  Time began_, last_received_, last_sent_;
  bool confirmed_ = false;
  ClientPath path_;
  WaitingRequests requests_;

  Outbox outbox_;
  Time planned_end_{};  ///< of the frame in the outbox, at the rate of when it was put
  Quality quality_;
  ViewScale job_scale_{};  ///< as advised when the job in work was taken
  bool job_is_cube_mask_ = false;
};

}  // namespace farshade
