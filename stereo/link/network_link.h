/// NetworkLink: the client's end of the network. It opens a session and keeps it alive, sends requests and
/// receives answers. It never blocks longer than the caller allows. A server that is absent, late or
/// restarted means fewer answers and has no other effect. A datagram that does not authenticate cannot end a
/// session.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "stereo/link/server_connection.h"
#include "stereo/net/arrivals.h"
#include "stereo/net/datagram.h"
#include "stereo/sealing/handshake.h"

namespace farshade {

/// The server, and what the client needs of it.
struct LinkTarget {
  Peer server;
  SharedKey key;
  ContentHash scene_hash{};
  MaskLayout mask;                            ///< the layout of all masks
  AnswerSet answers = set_of(Answer::Masks);  ///< the kinds of answers that the server must offer
};

/// Sees the messages of sessions before they take effect, but no Goodbye; a capture file is written from
/// them. A Welcome comes first, and again whenever a new session begins.
struct LinkListener {
  std::function<void(std::span<const std::byte> message, Time arrived)>
      received;                                           ///< opened, for decode_server
  std::function<void(const FrameRequest& request)> sent;  ///< as it is sent
};

/// A server that answers nothing for this long is reported as silent.
inline constexpr Duration kSilentAfter = std::chrono::seconds(1);

/// poll() reads datagrams for at most this time, which a frame of the client can spare. A server that sends
/// more than the client can decode gets its datagrams read in later frames, or dropped by the socket.
inline constexpr Duration kMostPolling = std::chrono::milliseconds(4);
/// Slow frames read for longer, so that what arrives between them does not wait for ever: this part of the
/// time since the last poll() ended, but no longer than kLongestPolling.
inline constexpr Duration::rep kPollingPart = 3;
inline constexpr Duration kLongestPolling = std::chrono::milliseconds(100);

class NetworkLink final : public ServerConnection {
 public:
  /// Keeps the records of `frames` requests. Keeps references to `port`, and to `clock`, which times waits.
  NetworkLink(DatagramPort& port, const Clock& clock, const LinkTarget& target, std::size_t frames);
  NetworkLink(const NetworkLink&) = delete;
  NetworkLink& operator=(const NetworkLink&) = delete;
  /// Tells the server that its session is over, so that its place there is free at once.
  ~NetworkLink() override;

  /// Sets the listener. Empty functions are not called.
  void tell(LinkListener listener) { listener_ = std::move(listener); }

  /// Sends hellos until a session is open or `patience` is over. Fails if the server refuses the client
  /// (Mismatch), does not answer (Missing) or is full (Unavailable). After the latter two the caller may go
  /// on, because the link keeps trying. Anybody can forge the refusal of a key or of a version, so it counts
  /// only if no session is open at the end of `patience`.
  [[nodiscard]] Expected<void> connect(Duration patience);

  /// Sends only those light changes that the server may not have yet.
  void request(const FrameRequest& request, Time requested_at, const RequestParts& parts = {}) override;

  /// Receives the datagrams that have arrived, for at most kMostPolling, or longer after a slow frame.
  void poll();

  /// Keeps the session of a client that asks for nothing: sends its newest request again. The server answers
  /// that with a Probe at most. Call it more often than once in kSessionTimeout.
  void keep_alive();

  /// Receives for a time of `span`.
  void listen(Duration span);

  bool wait_for(FrameId frame, Duration patience) override;

  /// From now on, waits for answers end at once when `gives_up` returns true, for example after Ctrl-C.
  void give_up_when(std::function<bool()> gives_up) { gives_up_ = std::move(gives_up); }

  [[nodiscard]] bool takes_parts() const override { return !listener_.sent; }
  [[nodiscard]] const FrameReceiver& receiver() const override { return receiver_; }

  [[nodiscard]] std::optional<std::string> goodbye() const override { return goodbye_; }

  /// Set once an authenticated server has refused this client for good.
  [[nodiscard]] const std::optional<Error>& refused() const override { return refused_; }
  /// When the last message of the open session came; no value without a session.
  [[nodiscard]] std::optional<Time> last_received() const {
    return channel_ ? std::optional(channel_->last_received) : std::nullopt;
  }

  /// On the clock of this link. An answer that takes less than kSilentAfter is not silence.
  [[nodiscard]] std::optional<Time> silent_since() const override;

  [[nodiscard]] std::optional<LinkTraffic> traffic() const override { return traffic_; }

  struct Counters {
    AssemblerCounters assembler;
    RefusalCounts undecodable;
    PortCounters port;
    std::uint64_t sessions = 0;   ///< begun so far
    std::uint64_t cut_short = 0;  ///< calls of poll() that ended before all datagrams were read
    std::uint64_t missing = 0;    ///< datagrams of this session, older than the newest, that have not come
  };
  [[nodiscard]] Counters counters() const;

  [[nodiscard]] Duration busy() const override { return busy_; }

 private:
  /// An open session.
  struct Channel {
    explicit Channel(const SessionKeys& keys, Time now);
    SessionId id;
    Sealer sealer;
    Opener opener;
    Arrivals arrivals{};
    std::uint64_t probe_echo = 0;
    Time last_received;
    std::optional<FrameId> newest_sent;  ///< of the requests of views
    std::uint32_t unanswered = 0;        ///< requests sent since then
    Time requested{};                    ///< when the first of them was sent
  };

  void send_outgoing();
  void wait_out(Duration span);
  bool receive_one(Duration wait);
  void keep_session();
  void say_hello();
  void send_request(const FrameRequest& request);
  void seal_request(const FrameRequest& request);
  void send_following(std::span<const std::vector<std::byte>> messages);
  Decoded<void> take_datagram(const Datagram& datagram);
  void take_refusal(const OpenRefusal& refusal);
  void take_accept(const Accept& accept, std::span<const std::byte> datagram);
  Decoded<void> take_sealed(const Sealed& sealed, const Datagram& datagram);
  void take(const Welcome&, Time) {}
  void take(const Refusal&, Time) {}
  void take(const Goodbye& goodbye, Time);
  void take(const PathProbe&, Time) {}
  void take(const Probe& probe, Time) { channel_->probe_echo = probe.token; }
  void take(const auto& piece_or_report, Time arrived) { receiver_.take(piece_or_report, arrived); }

  DatagramPort& port_;
  const Clock& clock_;
  LinkTarget target_;
  std::optional<ClientHandshake> handshake_;  ///< in progress
  std::optional<Channel> channel_;
  FrameReceiver receiver_;
  LinkListener listener_;
  std::function<bool()> gives_up_ = [] { return false; };
  std::optional<Time> last_hello_, first_hello_;
  std::optional<std::string> goodbye_{};  ///< why the server ended the last session; none while one is open
  std::optional<Error> refused_;
  std::optional<std::string> busy_server_;  ///< why a full server has refused
  /// Why there may be no session: a refusal without authentication.
  std::optional<std::string> unproved_refusal_;
  std::uint64_t sessions_ = 0, cut_short_ = 0;
  RefusalCounts undecodable_{};
  Duration busy_{};
  std::optional<Time> polled_{};  ///< when poll() last ended
  LinkTraffic traffic_;
  std::vector<std::byte> message_, outgoing_;
  std::array<std::byte, kMaxDatagram_bytes> incoming_{};
};

}  // namespace farshade
