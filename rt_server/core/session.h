/// ClientSession: all that the server keeps of one client that has proved address and key. A value without
/// sockets, threads or clocks; of bounded size, and none of it shared with another client.
#pragma once

#include <optional>
#include <string>

#include "rt_server/core/outbox.h"
#include "rt_server/core/quality.h"
#include "stereo/net/datagram.h"
#include "stereo/net/rate_control.h"
#include "stereo/wire/handshake.h"

namespace farshade {

/// A request whose turn has come.
struct Job {
  SessionId session;
  FrameRequest request;
  Time arrived;
  std::uint32_t superseded = 0;        ///< of this client's requests, so far
  std::uint32_t bytes_per_second = 0;  ///< that the path to it carries
  ViewScale view_scale{};              ///< the size of views that the client should request next
  /// PlaneSlices of the request's positions that have come, each a message of its own that was decoded once.
  std::vector<std::vector<std::byte>> positions{};
};

/// Of positions that one request may bring, in messages; what comes beyond it is dropped.
inline constexpr std::size_t kMostPositions_bytes = std::size_t{16} << 20;
/// A request whose positions do not come any more is answered with those that have.
inline constexpr Duration kPositionsLull = std::chrono::milliseconds(10);

/// What a client's datagram was, once opened.
enum class ReceivedMessage : std::uint8_t {
  News,        ///< a request newer than all before
  Superseded,  ///< the same, and it took the place of one that waited
  Outdated,    ///< a request not newer than one that came before
  TooLarge,    ///< a request for more pixels than may be asked for
  Unanswered,  ///< a request for what this server does not give
  Positions,   ///< some of those of the request that waits
  Stray,       ///< positions of another request, or too many
};

class ClientSession {
 public:
  ClientSession(std::string name, const Peer& client, const PublicKey& hello, const Accepted& accepted,
                Time now, const RateLimits& limits, const Welcome& served);

  [[nodiscard]] SessionId id() const { return id_; }
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const Peer& client() const { return client_; }
  [[nodiscard]] const PublicKey& hello() const { return hello_; }
  /// The answer to its hello, to be said again if the hello comes again.
  [[nodiscard]] std::span<const std::byte> accept_datagram() const { return accept_; }
  [[nodiscard]] Time heard_at() const { return heard_; }
  /// Something of the client's has opened: it holds the keys.
  [[nodiscard]] bool is_confirmed() const { return confirmed_; }

  /// Opens and takes `sealed`, read from `datagram`. `probe` becomes a datagram to send back to `from`, or is
  /// left empty.
  [[nodiscard]] Decoded<ReceivedMessage> take(const Peer& from, const Sealed& sealed,
                                              std::span<const std::byte> datagram, Time now,
                                              std::vector<std::byte>& probe);

  /// A request waits with all that it brings, and the frame before it has left and is through the path; so a
  /// slow path lowers the mask rate.
  [[nodiscard]] bool is_ready(Time now) const {
    const std::optional<Time> at = ready_at();
    return at && now >= *at;
  }
  /// When is_ready becomes true if nothing else happens.
  [[nodiscard]] std::optional<Time> ready_at() const;
  [[nodiscard]] Job take_job();

  /// Whose turn it is: the least of these comes first.
  struct Turn {
    Duration work{};  ///< that was done for this client, counted from where the others stood when it came
    std::uint64_t served = 0;  ///< jobs of all clients when it was served last, or came
    friend auto operator<=>(const Turn&, const Turn&) = default;
  };
  Turn turn;

  /// The messages of a traced frame, to leave evenly over the frame interval.
  void put(std::span<const std::vector<std::byte>> messages, Time now);

  [[nodiscard]] std::optional<Time> due() const { return outbox_.due(); }
  /// Seals the message that is due.
  void seal_due(Time now, std::vector<std::byte>& datagram);

  [[nodiscard]] const RateControl& rate() const { return rate_; }
  [[nodiscard]] std::uint64_t held_back() const { return held_back_; }

 private:
  ReceivedMessage take(const RequestMessage& message, Time now);
  ReceivedMessage take_positions(const PlaneSlice& slice, std::span<const std::byte> message, Time now);
  void follow(const Peer& from, bool newest, std::uint64_t probe_echo, std::vector<std::byte>& probe);
  void give_sign_of_life(std::vector<std::byte>& probe);
  void learn_interval(const FrameRequest& request, Time now);

  std::string name_;
  SessionId id_;
  PublicKey hello_;
  std::vector<std::byte> accept_;
  Opener opener_;
  Sealer sealer_;
  RateLimits limits_;
  std::uint32_t most_pixels_;
  AnswerSet answers_;

  Peer client_;                    ///< has proved that it is there
  std::optional<Peer> candidate_;  ///< where its newest datagrams come from, if from elsewhere
  std::uint64_t probe_token_ = 0;

  Time heard_, told_;  ///< when something came from it, and was sent to it
  bool confirmed_ = false;
  std::optional<FrameId> newest_{};
  Time newest_display_{}, newest_arrived_{};
  Duration interval_{};  ///< from one request to the next, as the client's display and our clock have it
  std::optional<Job> waiting_{};
  std::size_t positions_bytes_ = 0;  ///< of those that wait with it
  Time position_heard_{};            ///< the last of them
  std::uint32_t superseded_ = 0;
  LightChanges lights_;

  Outbox outbox_;
  RateControl rate_;
  Quality quality_;
  ViewScale job_scale_{};        ///< as advised when the job in work was taken
  std::uint64_t held_back_ = 0;  ///< frames that left slower because of the limit of bytes a second
  std::vector<std::byte> message_;
};

}  // namespace farshade
