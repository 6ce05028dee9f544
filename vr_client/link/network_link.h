/// NetworkLink: the client's end of the wire. Gets a session and keeps it, sends what is to be traced,
/// assembles what comes back, hands out the masks in hand, newest first. Never blocks longer than it was
/// told; a server that is gone, late or restarted means fewer masks, nothing else. Nothing that has not
/// opened ends anything.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "stereo/net/arrivals.h"
#include "stereo/net/datagram.h"
#include "stereo/wire/handshake.h"
#include "vr_client/link/answer_link.h"

namespace farshade {

/// Whom to talk to, and about what.
struct LinkTarget {
  Peer server;
  SharedKey key;
  ContentHash scene_hash{};
  MaskLayout mask;                            ///< of every mask that comes
  AnswerSet answers = set_of(Answer::Masks);  ///< that the server must give
};

/// Told what is said within sessions, before it is taken in: what a session on file is made of. A Welcome
/// comes first and whenever a new session begins.
struct LinkListener {
  std::function<void(std::span<const std::byte> message, Time arrived)> heard;  ///< as decode_server takes it
  std::function<void(const FrameRequest& request)> asked;                       ///< as it goes out
};

class NetworkLink final : public AnswerLink {
 public:
  /// Remembers `frames` requests, as Assembler does. `port` and `clock`, which times waits, outlive it.
  NetworkLink(DatagramPort& port, const Clock& clock, const LinkTarget& target, std::size_t frames);

  /// From now on; empty functions are not called.
  void tell(LinkListener listener) { listener_ = std::move(listener); }

  /// Says hello until the server welcomes us or `patience` is over. Refuses what the server refuses
  /// (Mismatch), a server that does not answer (Missing) or has no room (Unavailable); after the latter two
  /// one may go on, the link keeps trying.
  [[nodiscard]] Expected<void> meet(Duration patience);

  /// Of the light set that `request` speaks of goes what the server is not known to have.
  void request(const FrameRequest& request, Time asked_at,
               std::span<const std::vector<std::byte>> positions = {}) override;

  /// Takes in all that has arrived.
  void poll();

  /// Takes in what arrives for so long.
  void listen(Duration span);

  bool wait_for(FrameId frame, Duration patience) override;

  [[nodiscard]] const AnswerInbox& inbox() const override { return inbox_; }

  /// Set once the server has proved itself and said it.
  [[nodiscard]] const std::optional<Error>& refused() const override { return refused_; }
  /// A session is open, as far as we know.
  [[nodiscard]] bool welcomed() const { return channel_ && !handshake_; }
  /// When something of the session at hand last came; nothing before there is one.
  [[nodiscard]] std::optional<Time> heard_at() const {
    return channel_ ? std::optional(channel_->heard) : std::nullopt;
  }

  struct Counters {
    AssemblerCounters assembler;
    RefusalCounts undecodable;
    PortCounters port;
    std::uint64_t sessions = 0;  ///< begun
    std::uint64_t missing =
        0;  ///< datagrams of this session that have not come, of those sent before the newest
  };
  [[nodiscard]] Counters counters() const;

  [[nodiscard]] Duration busy() const override { return busy_; }

 private:
  /// A session.
  struct Channel {
    explicit Channel(const SessionKeys& keys, Time now);
    SessionId id;
    Sealer sealer;
    Opener opener;
    Arrivals arrivals{};
    std::uint64_t probe_echo = 0;
    Time heard;
    std::uint32_t unanswered = 0;  ///< requests since then
  };

  bool receive_one(Duration wait);
  void keep_session();
  void say_hello();
  void send_request(const FrameRequest& request);
  void send_positions(std::span<const std::vector<std::byte>> messages);
  Decoded<void> take_datagram(const Datagram& datagram);
  void take_refusal(const OpenRefusal& refusal);
  void take_accept(const Accept& accept, std::span<const std::byte> datagram);
  Decoded<void> take_sealed(const Sealed& sealed, const Datagram& datagram);
  void take(const Welcome&, Time) {}
  void take(const Refusal&, Time) {}
  void take(const Slice& slice, Time arrived) { inbox_.take(slice, arrived); }
  void take(const PlaneSlice& slice, Time arrived) { inbox_.take(slice, arrived); }
  void take(const VideoPart& part, Time arrived) { inbox_.take(part, arrived); }
  void take(const FrameReport& report, Time arrived) { inbox_.take(report, arrived); }
  void take(const Probe& probe, Time) { channel_->probe_echo = probe.token; }

  DatagramPort& port_;
  const Clock& clock_;
  LinkTarget target_;
  std::optional<ClientHandshake> handshake_;  ///< under way
  std::optional<Channel> channel_;
  AnswerInbox inbox_;
  LinkListener listener_;
  std::optional<Time> last_hello_;
  std::optional<Error> refused_;
  std::optional<std::string> busy_server_;  ///< what a server without room has said
  /// Why there may be no session; from somebody who has proved nothing, at `hearsay_at_`.
  std::string hearsay_;
  std::optional<Time> hearsay_at_;
  std::uint64_t sessions_ = 0;
  RefusalCounts undecodable_{};
  Duration busy_{};
  std::vector<std::byte> message_, outgoing_;
  std::array<std::byte, kMaxDatagram_bytes> incoming_{};
};

}  // namespace farshade
