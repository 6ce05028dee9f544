/// ClientSession: everything that the server stores for one client that has proved its address and its key.
/// A value of bounded size, without sockets, threads or clocks. Sessions share no data.
#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <string>

#include "rt_server/scheduling/quality.h"
#include "stereo/frame/cube_mask.h"
#include "stereo/messages/timing.h"
#include "stereo/net/datagram.h"
#include "stereo/net/path_mtu.h"
#include "stereo/net/rate_control.h"
#include "stereo/sealing/handshake.h"

namespace farshade {

/// A request that is to be answered now.
struct Job {
  SessionId session;
  KeyId key{};                         ///< of the session
  Version version = kProtocolVersion;  ///< of the session
  FrameRequest request;
  Time arrived;
  std::uint32_t superseded = 0;        ///< requests of this client so far that a newer one replaced
  std::uint32_t bytes_per_second = 0;  ///< estimated capacity of the path to the client
  ViewScale view_scale{};              ///< the size of views that the client should request next
  std::size_t most_message_bytes = kBaseMessage_bytes;  ///< that the path to the client carries
  /// The messages that the request announced and that have arrived: AskSlices with the blocks that it asks
  /// for, or PlaneSlices with its positions. Each has been decoded once, so it is well-formed.
  std::vector<std::vector<std::byte>> parts{};
  bool is_too_costly = false;           ///< gets an answer without content (rt_server/scheduling/job_costs.h)
  std::function<bool()> is_given_up{};  ///< whether to stop work on it; empty: never. Any thread may call it
};

/// How a job ended.
enum class JobEnd : std::uint8_t {
  Answered,
  GivenUp,  ///< also without having begun, because it was too costly
};

/// Maximum total size of the messages that follow one request. The server drops messages beyond it, and
/// those with more tiles than the requested views have.
inline constexpr std::size_t kMostParts_bytes = std::size_t{16} << 20;

/// A message that waits takes so much more memory than it has bytes.
inline constexpr std::size_t kMessage_bytes = 64;
/// Memory of a session in which nothing waits: 141,425 bytes were measured, most of them what the rate
/// control remembers.
inline constexpr std::size_t kSession_bytes = 144 << 10;

/// What an opened datagram of the client contained.
enum class ReceivedMessage : std::uint8_t {
  NewRequest,  ///< a request newer than all before
  Superseded,  ///< the same, and it replaced one that was waiting
  Outdated,    ///< a request that is not newer than all before
  TooLarge,    ///< a request for more pixels than the server allows
  Unanswered,  ///< a request for an answer that the server does not offer
  Part,        ///< a message that the waiting request announced
  Stray,       ///< one of another request, or more than it announced
  OverMemory,  ///< one for which its key has no memory left
  Left,        ///< the client's last message: its session is over
};

/// Sends the datagrams of one frame evenly over a part of the frame interval, and never faster than the path
/// takes them at the moment. The session's next frame is traced when its outbox is empty and the path has
/// drained. So a slow path lowers the mask rate and does not build a queue. It holds only what is not yet
/// sent.
class Outbox {
 public:
  /// Takes the messages of one frame. The outbox must be empty. The first message is due at `now`, or at
  /// drained_at() if that is later; the others follow at least an equal share of `spread` apart.
  void put(std::vector<std::vector<std::byte>> messages, Time now, Duration spread);

  /// When the next message is due; nothing if the outbox is empty.
  [[nodiscard]] std::optional<Time> due() const;

  /// Removes the next message. The outbox must not be empty. The message after it is due when the path has
  /// taken this one at `bytes_per_second` (> 0), the rate of now, or after the share if that is longer. It
  /// does not matter when take() is called: after a delay several are due.
  [[nodiscard]] std::vector<std::byte> take(double bytes_per_second);

  [[nodiscard]] bool empty() const { return taken_ == messages_.size(); }
  /// Memory of the messages that are not yet sent.
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

  /// When the path has taken all messages, if it goes on with `bytes_per_second` (> 0).
  [[nodiscard]] Time ends_at(double bytes_per_second) const;

  /// Removes the messages that are left.
  void drop();

  /// When the path has taken all messages that were taken from here, at the rates of then. The clock's zero
  /// before the first put().
  [[nodiscard]] Time drained_at() const { return next_due_; }

 private:
  std::vector<std::vector<std::byte>> messages_;  ///< of one frame; those taken are empty
  std::size_t taken_ = 0, bytes_ = 0;
  std::size_t bytes_left_ = 0;  ///< total size of those not taken
  Duration share_{};
  Time next_due_{};
};

class ClientSession {
 public:
  ClientSession(const SharedKey& key, const Peer& client, const PublicKey& hello, const Accepted& accepted,
                Time now, const RateLimits& limits, const Welcome& served);

  /// Sets the limits of the rate from now on.
  void limit(const RateLimits& limits);

  [[nodiscard]] SessionId id() const { return id_; }
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const KeyId& key() const { return key_; }
  [[nodiscard]] const Peer& client() const { return client_; }
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
  [[nodiscard]] std::size_t bytes() const {
    const std::size_t parts = waiting_ ? parts_bytes_ + kMessage_bytes * waiting_->parts.size() : 0;
    return kSession_bytes + parts + outbox_.bytes();
  }

  [[nodiscard]] bool has_requested() const {
    return newest_ ||
           std::ranges::any_of(newest_cube_mask_, [](const auto& frame) { return frame.has_value(); });
  }
  /// The kind of answer that the last accepted request wants; none before the first.
  [[nodiscard]] std::optional<Answer> requested_answer() const { return requested_answer_; }
  /// From now on accepts only requests for `answers`.
  void offer(AnswerSet answers) { answers_ = answers; }

  /// A request for the cube mask is taken before another one only if so many others have overtaken it.
  static constexpr std::uint32_t kMostOvertaking = 3;

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

  /// Queues the messages of an answer. They leave evenly over a share of the frame interval; those of the
  /// cube mask, which delay the next answer, as fast as the path takes them.
  void put(std::vector<std::vector<std::byte>> messages, Time now, JobEnd end = JobEnd::Answered);

  /// When seal_due() has a message to send.
  [[nodiscard]] std::optional<Time> due() const { return outbox_.due(); }
  /// Removes the next message from the queue and seals it into `datagram`.
  void seal_due(Time now, std::vector<std::byte>& datagram);

  /// Seals the last message of this session into `datagram`.
  void seal_goodbye(EndReason reason, std::vector<std::byte>& datagram);

  /// Frames that left more slowly because of the limit of bytes per second.
  [[nodiscard]] std::uint64_t held_back() const { return held_back_; }
  /// Frames of which a newer one replaced the rest.
  [[nodiscard]] std::uint64_t overtaken() const { return frames_overtaken_; }
  /// The client has reported the arrival of a datagram that was never sent. Since then it gets the least
  /// rate.
  [[nodiscard]] bool got_false_report() const { return rate_.got_false_report(); }
  /// The largest datagram that the path to the client's present address is known to carry, in bytes.
  [[nodiscard]] std::size_t most_datagram_bytes() const { return path_mtu_.bytes(); }
  /// Times that the path to the client's present address stopped to carry large datagrams.
  [[nodiscard]] std::uint64_t black_holes() const { return path_mtu_.black_holes(); }

  /// One of so many datagrams, on average and at random, is followed by a counter that no datagram has.
  static constexpr std::uint32_t kBetweenGaps = 512;

 private:
  ReceivedMessage receive(const RequestMessage& message, Time now);
  [[nodiscard]] std::optional<ReceivedMessage> refuse_request(const FrameRequest& request) const;
  [[nodiscard]] std::optional<Job>& waiting_for(const FrameRequest& request);
  [[nodiscard]] std::optional<std::size_t> oldest_cube_mask() const;
  [[nodiscard]] bool is_complete() const;
  [[nodiscard]] bool is_late() const;
  template <class TileSlice>
  ReceivedMessage receive_part(Answer of, const TileSlice& slice, std::span<const std::byte> message,
                               Time now, std::size_t room);
  void update_address(const Peer& from, bool newest, std::uint64_t probe_echo, std::vector<std::byte>& probe);
  /// Returns the counter, which the caller tells the rate control.
  std::uint64_t seal_probe(std::uint64_t token, std::vector<std::byte>& probe);
  void probe_path(Time now, std::vector<std::byte>& probe);
  void record_sent(std::uint64_t counter, std::size_t bytes, Time now);
  void update_interval(const FrameRequest& request, Time now);

  std::string name_;
  KeyId key_;
  SessionId id_;
  Version version_;
  PublicKey hello_;
  std::vector<std::byte> accept_;
  Opener opener_;
  Sealer sealer_;
  RateLimits limits_;
  std::uint32_t most_pixels_;
  AnswerSet answers_;

  Peer client_;                    ///< proved address: frames go there
  std::optional<Peer> candidate_;  ///< another address, from which the newest datagrams came
  std::uint64_t probe_token_ = 0;  ///< sent to the candidate, which must send it back

  Time began_, last_received_, last_sent_;
  bool confirmed_ = false;
  std::optional<FrameId> newest_{};
  std::optional<Answer> requested_answer_{};
  Time newest_display_{}, newest_arrived_{};  ///< display time and arrival of the newest request
  Duration interval_{};                       ///< mean time between two requests
  std::optional<Job> waiting_{};
  /// Requests for the cube mask wait apart, so that they and the others do not replace each other; one of
  /// each pair.
  std::array<std::optional<Job>, kCubeMaskPairs> waiting_cube_mask_{};
  std::array<std::optional<FrameId>, kCubeMaskPairs> newest_cube_mask_{};
  std::uint32_t overtaken_ = 0;  ///< other requests that were taken while the cube mask's waited
  std::size_t parts_bytes_ = 0;  ///< total size of waiting_->parts
  std::size_t tiles_left_ = 0;   ///< that further parts may have: the worker decodes each
  Time part_arrived_{};          ///< arrival of the newest of them, or of their request
  std::uint32_t superseded_ = 0;
  LightChanges lights_;

  Outbox outbox_;
  Time planned_end_{};  ///< of the frame in the outbox, at the rate of when it was put
  RateControl rate_;
  PathMtu path_mtu_;
  Quality quality_;
  ViewScale job_scale_{};  ///< as advised when the job in work was taken
  bool job_is_cube_mask_ = false;
  std::uint64_t held_back_ = 0, frames_overtaken_ = 0;
  std::uint32_t until_gap_;  ///< datagrams to the next counter that is left out
  std::vector<std::byte> message_;
};

}  // namespace farshade
