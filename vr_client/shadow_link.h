/// ShadowLink: the client's end of the wire. Gets a session and keeps it, sends what is to be traced,
/// assembles what comes back, hands out the masks in hand, newest first. Never blocks longer than it was
/// told; a server that is gone, late or restarted means fewer masks, nothing else. Nothing that has not
/// opened ends anything.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "stereo/net/arrivals.h"
#include "stereo/net/assembler.h"
#include "stereo/net/datagram.h"
#include "stereo/wire/handshake.h"

namespace farshade {

/// Whom to talk to, and about what.
struct LinkTarget {
  Peer server;
  SharedKey key;
  ContentHash scene_hash{};
  std::uint32_t lights = 0;  ///< in every mask
};

class ShadowLink {
 public:
  /// Remembers `frames` requests, as Assembler does. `port` and `clock`, which times waits, outlive it.
  ShadowLink(DatagramPort& port, const Clock& clock, const LinkTarget& target, std::size_t frames);

  /// Says hello until the server welcomes us or `patience` is over. Refuses what the server refuses
  /// (Mismatch), a server that does not answer (Missing) or has no room (Unavailable); after the latter two
  /// one may go on, the link keeps trying.
  [[nodiscard]] Expected<void> meet(Duration patience);

  /// `asked_at` is the display time of the frame that asks; masks() tells frames apart by it. Of the light
  /// set that `request` speaks of goes what the server is not known to have.
  void request(const TraceRequest& request, Time asked_at);

  /// Takes in all that has arrived.
  void poll();

  /// Takes in what arrives for so long.
  void listen(Duration span);

  /// Takes in what arrives until `frame` is whole or `patience` is over. True if it is whole.
  bool wait_for(FrameId frame, Duration patience);

  /// Frames of which something is known and that were asked for up to the display time `until`, newest first.
  [[nodiscard]] std::vector<const ReceivedFrame*> masks(Time until) const;

  /// When a frame that is still remembered was asked for.
  [[nodiscard]] std::optional<Time> asked_at(FrameId frame) const;

  /// Null if nothing of it is in hand.
  [[nodiscard]] const ReceivedFrame* find(FrameId frame) const { return assembler_.find(frame); }

  /// A refusal that no waiting can cure, once the server has proved itself and said it.
  [[nodiscard]] const std::optional<Error>& refused() const { return refused_; }
  /// A session is open, as far as we know.
  [[nodiscard]] bool welcomed() const { return channel_ && !handshake_; }

  /// Of an eye, that the server traces; as it said when it welcomed us.
  [[nodiscard]] std::uint32_t most_pixels() const { return most_pixels_; }

  /// Of their size, that views should be asked for: what the server takes the path to carry.
  [[nodiscard]] std::uint32_t scale_eighths() const { return scale_eighths_; }

  struct Counters {
    AssemblerCounters assembler;
    RefusalCounts undecodable;
    PortCounters port;
    std::uint64_t sessions = 0;  ///< begun
    std::uint64_t missing =
        0;  ///< datagrams of this session that have not come, of those sent before the newest
  };
  [[nodiscard]] Counters counters() const;

  /// Time spent so far on opening, decoding and assembling, waits not counted.
  [[nodiscard]] Duration busy() const { return busy_; }

 private:
  /// A session.
  struct Channel {
    explicit Channel(const SessionKeys& keys, Time now);
    SessionId id;
    Sealer sealer;
    Opener opener;
    Arrivals arrivals{};
    std::uint64_t probe_echo = 0;
    std::uint32_t acknowledged = kFirstLightSet;  ///< the light set that the server surely has
    Time heard;
    std::uint32_t unanswered = 0;  ///< requests since then
  };

  bool receive_one(Duration wait);
  void keep_session();
  void say_hello();
  void send_request(const TraceRequest& request);
  Decoded<void> take_datagram(const Datagram& datagram);
  void take_refusal(const OpenRefusal& refusal);
  void take_accept(const Accept& accept, std::span<const std::byte> datagram);
  Decoded<void> take_sealed(const Sealed& sealed, const Datagram& datagram);
  void take(const Welcome&) {}
  void take(const Refusal&) {}
  void take(const Slice& slice);
  void take(const FrameReport& report);
  void take(const Probe& probe) { channel_->probe_echo = probe.token; }

  DatagramPort& port_;
  const Clock& clock_;
  LinkTarget target_;
  std::optional<ClientHandshake> handshake_;  ///< under way
  std::optional<Channel> channel_;
  Assembler assembler_;
  struct Asked {
    FrameId frame;
    Time at;
    SessionId session;
  };
  std::vector<Asked> asked_;  ///< oldest first; those that the assembler remembers
  std::optional<Time> last_hello_;
  std::optional<Error> refused_;
  std::optional<std::string> busy_server_;  ///< what a server without room has said
  /// Why there may be no session; from somebody who has proved nothing, at `hearsay_at_`.
  std::string hearsay_;
  std::optional<Time> hearsay_at_;
  std::uint32_t scale_eighths_ = kFullScale_eighths;
  std::uint32_t most_pixels_ = Welcome{}.most_pixels;
  std::optional<FrameId> newest_report_;
  std::uint64_t sessions_ = 0;
  RefusalCounts undecodable_{};
  Duration busy_{};
  std::vector<std::byte> message_, outgoing_;
  std::array<std::byte, kMaxDatagram_bytes> incoming_{};
};

}  // namespace farshade
